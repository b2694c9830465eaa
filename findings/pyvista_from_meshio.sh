#!/usr/bin/env bash
# PyVista 0.49.1: from_meshio empties the cell sets of the mesh that it reads.
# Expected: a conversion leaves its argument as it was, and the mesh can be written or converted a second time.
# What happens: the sets turn into one cell array of numbers by meshio's own routine, which takes them out of the mesh.
# A second conversion, or a file written afterwards, goes by other data than the first.
# Output seen:
#   before ['journal', 'web'], after [], arrays of the grid ['journal-web']
set -euo pipefail
folder=$(mktemp -d); trap 'rm -rf "$folder"' EXIT; cd "$folder"
python3 -m venv venv && venv/bin/pip install -q meshio==5.3.5 pyvista==0.49.1 vtk==9.7.2 numpy==2.4.6
venv/bin/python - <<'PY'
import sys

import meshio
import numpy as np
import pyvista

points = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]])
sets = {"journal": [np.array([0])], "web": [np.array([], int)]}
mesh = meshio.Mesh(points, [("tetra", np.arange(4)[None])], cell_sets=sets)
before = sorted(mesh.cell_sets)
grid = pyvista.from_meshio(mesh)
after = sorted(mesh.cell_sets)
print(f"before {before}, after {after}, arrays of the grid {sorted(grid.cell_data)}")
sys.exit(0 if before == ["journal", "web"] and after != before else "changed")
PY
