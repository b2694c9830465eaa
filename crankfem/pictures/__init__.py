"""Pictures of a run: rendered solids (pyvista) and diagrams (matplotlib)."""
