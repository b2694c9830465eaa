"""Diagrams that answer the mouse: the same as the static ones, as plotly figures in small JSON files."""
