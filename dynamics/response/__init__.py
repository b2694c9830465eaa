"""Forced vibration by orders of a linear system: a chain, or a whole crankshaft."""
