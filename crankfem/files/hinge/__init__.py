"""Hinge files: a crosshead engine and its elastic hinge."""
