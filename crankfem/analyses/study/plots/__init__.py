"""Diagrams of a study's equations."""
