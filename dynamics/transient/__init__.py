"""Vibration over time: steady and transient integration of a chain's equations of motion."""
