"""Calculations from a file: each folder has the run, its result and its record."""
