"""Harmonics, lumped chains, critical speeds. Internal: import `crankfem`."""
