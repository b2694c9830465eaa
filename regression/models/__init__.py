"""Compliance models: equations in a file, evaluated by dimensions; optimum search."""
