"""Diagrams of an elastic hinge."""
