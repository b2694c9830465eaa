"""Checks of what comes from outside: each refuses with one clear sentence."""
