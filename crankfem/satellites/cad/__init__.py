"""Crankshafts from CAD: a STEP file becomes throws, their compliances and masses."""
