"""Diagrams of studies, equations and formulas."""
