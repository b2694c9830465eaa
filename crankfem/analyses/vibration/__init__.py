"""Vibration of an engine from its file: chains, modes, forced response, and a verdict."""
