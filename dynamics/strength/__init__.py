"""Strength of crankshafts by IACS unified requirement M53."""
