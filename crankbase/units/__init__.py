"""Quantities with units: read from text, displayed, written with a number of digits."""
