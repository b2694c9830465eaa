"""What throws, crankshafts and meshes look like, drawn on the axes of a diagram."""
