"""Crank-throw parameters to solid to mesh; mass properties. Internal: import `crankfem`."""
