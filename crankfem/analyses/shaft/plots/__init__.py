"""Diagrams of a whole crankshaft's modes and vibration."""
