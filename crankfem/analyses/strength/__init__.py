"""Strength of an engine's crankshaft."""
