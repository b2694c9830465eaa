"""Calibration: a chain's values fitted to measured orders, with what the records cannot tell."""
