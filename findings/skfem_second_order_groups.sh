#!/usr/bin/env bash
# scikit-fem 12.0.2: a mesh of 10-node tetrahedra loses its named boundaries, the same mesh of 4-node tetrahedra keeps them.
# Expected: from_meshio (and Mesh.load) finds the face "bore" that the file names, as its solids, or says that it cannot.
# What happens: mesh.boundaries is None, without a warning: the six nodes of a triangle are looked for among facets of three.
# Solids stay, so a look at mesh.subdomains hides it, and a load on "bore" fails far from the cause.
# Output seen:
#   tetra MeshTet1 boundaries ['bore'] subdomains ['web']
#   tetra10 MeshTet2 boundaries None subdomains ['web']
set -euo pipefail
folder=$(mktemp -d); trap 'rm -rf "$folder"' EXIT; cd "$folder"
python3 -m venv venv && venv/bin/pip install -q scikit-fem==12.0.2 meshio==5.3.5 numpy==2.4.6
venv/bin/python - <<'PY'
import sys

import meshio
import numpy as np
from skfem.io.meshio import from_meshio

corners = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]])
middles = [(corners[i] + corners[j]) / 2 for i, j in ((0, 1), (1, 2), (0, 2), (0, 3), (1, 3), (2, 3))]
points = np.vstack([corners, middles])
face = np.array([[0, 2, 1, 6, 5, 4]])
seen = []
for solid, surface, corner, side in (("tetra", "triangle", 4, 3), ("tetra10", "triangle6", 10, 6)):
    cells = [(solid, np.arange(corner)[None]), (surface, face[:, :side])]
    none, first = np.array([], int), np.array([0])
    sets = {"bore": [none, first], "web": [first, none]}
    mesh = from_meshio(meshio.Mesh(points[:corner], cells, cell_sets=sets))
    seen.append(list(mesh.boundaries) if mesh.boundaries else None)
    print(solid, type(mesh).__name__, "boundaries", seen[-1], "subdomains", list(mesh.subdomains))
sys.exit(0 if seen == [["bore"], None] else "changed")
PY
