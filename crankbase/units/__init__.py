"""Quantities with units: read from text, shown to people, written with so many digits."""
