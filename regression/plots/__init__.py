"""What studies, equations and formulas say, drawn on the axes of a diagram."""
