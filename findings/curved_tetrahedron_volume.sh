#!/usr/bin/env bash
# Volume of a 10-node tetrahedron with one edge bowed out, by gmsh 4.15.2, MEDCoupling 9.15.0 and VTK 9.7.2 (PyVista 0.49.1).
# Expected: a program that reads second-order cells measures them as second-order cells: one volume, all the same.
# What happens: four measures, three values. gmsh's element quality "volume" and MEDCoupling take the four corners alone,
# VTK straight pieces between all ten nodes; only gmsh's Jacobian at Gauss points is the volume of the element.
# Output seen:
#   gmsh quality 0.16667, MEDCoupling 0.16667, VTK 0.21667, gmsh integral 0.23333
set -euo pipefail
folder=$(mktemp -d); trap 'rm -rf "$folder"' EXIT; cd "$folder"
python3 -m venv venv && venv/bin/pip install -q gmsh==4.15.2 medcoupling==9.15.0 pyvista==0.49.1 vtk==9.7.2 numpy==2.4.6
venv/bin/python - <<'PY'
import sys

import gmsh
import medcoupling
import numpy as np
import pyvista

corners = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]])
middles = [(corners[i] + corners[j]) / 2 for i, j in ((0, 1), (1, 2), (0, 2), (0, 3), (1, 3), (2, 3))]
points = np.vstack([corners, middles])
points[5] += [0.2, 0.2, 0.0]
grid = pyvista.UnstructuredGrid(np.array([10, *range(10)]), [pyvista.CellType.QUADRATIC_TETRA], points)
gmsh.initialize()
gmsh.option.setNumber("General.Verbosity", 1)
solid = gmsh.model.addDiscreteEntity(3)
gmsh.model.mesh.addNodes(3, solid, range(1, 11), points.ravel())
gmsh.model.mesh.addElementsByType(solid, 11, [1], [1, 2, 3, 4, 5, 6, 7, 8, 10, 9])
gmsh.model.addPhysicalGroup(3, [solid], name="all")
gmsh.write("one.med")
local, weights = gmsh.model.mesh.getIntegrationPoints(11, "Gauss4")
volumes = {
    "gmsh quality": gmsh.model.mesh.getElementQualities([1], "volume")[0],
    "MEDCoupling": abs(medcoupling.MEDFileUMesh("one.med")[0].getMeasureField(True).accumulate()[0]),
    "VTK": grid.compute_cell_sizes()["Volume"][0],
    "gmsh integral": float(gmsh.model.mesh.getJacobians(11, local)[1] @ weights),
}
print(", ".join(f"{name} {volume:.5f}" for name, volume in volumes.items()))
quality, med, vtk, integral = volumes.values()
sys.exit(0 if np.isclose(quality, med) and vtk - med > 0.01 and abs(integral - vtk) > 0.005 else "changed")
PY
