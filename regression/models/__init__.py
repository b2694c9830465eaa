"""Compliance models: equations in a file, asked by dimensions; optimum search."""
