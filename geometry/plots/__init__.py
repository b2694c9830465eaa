"""Drawings of throws, crankshafts and meshes on the axes of a diagram."""
