"""What finite elements found, drawn on the axes of a diagram."""
