"""Free inertia forces and moments of the moving parts, by order."""
