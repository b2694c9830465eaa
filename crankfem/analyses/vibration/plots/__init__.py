"""Diagrams of an engine's vibration."""
