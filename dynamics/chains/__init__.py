"""Chains of inertias and springs: their description, modes, and the chains that engines lead to."""
