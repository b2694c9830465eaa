"""Chains of inertias and springs: their description, modes, and the chains of engines."""
