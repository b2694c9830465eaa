"""Mesh to stiffness to superelement to compliance and reactions. Internal: import `crankfem`."""
