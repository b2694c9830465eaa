"""Mechanism, torque and balance; chains, forced vibration and its verdict. Internal: import `crankfem`."""
