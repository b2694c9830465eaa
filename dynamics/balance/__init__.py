"""What the inertia of the moving parts leaves over: forces and moments on the engine, by order."""
