"""Checks of input: each refuses with one clear sentence."""
