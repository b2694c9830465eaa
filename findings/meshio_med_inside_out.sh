#!/usr/bin/env bash
# meshio 5.3.5 writes MED files whose tetrahedra are inside out for MEDCoupling 9.15.0 and without its cell sets.
# Expected: a tetrahedron of volume 1/6 has volume 1/6 in the program the format belongs to, and sets become groups.
# What happens: nodes are written in the order of VTK, while MED counts the second and third corner the other way round:
# volume -1/6 for linear and quadratic cells. MEDCoupling's own check passes. Only cell tags become groups, sets are lost.
# Output seen:
#   tetra: volume -0.1667, groups ()
#   tetra10: volume -0.1667, groups ()
set -euo pipefail
folder=$(mktemp -d); trap 'rm -rf "$folder"' EXIT; cd "$folder"
python3 -m venv venv && venv/bin/pip install -q meshio==5.3.5 medcoupling==9.15.0 h5py==3.16.0 numpy==2.4.6
venv/bin/python - <<'PY'
import sys

import medcoupling
import meshio
import numpy as np

corners = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]])
middles = [(corners[i] + corners[j]) / 2 for i, j in ((0, 1), (1, 2), (0, 2), (0, 3), (1, 3), (2, 3))]
points = np.vstack([corners, middles])
seen = []
for kind, nodes in (("tetra", 4), ("tetra10", 10)):
    mesh = meshio.Mesh(points[:nodes], [(kind, np.arange(nodes)[None])], cell_sets={"web": [np.array([0])]})
    mesh.write("one.med")
    file = medcoupling.MEDFileUMesh("one.med")
    file[0].checkConsistencyLight()
    seen.append((file[0].getMeasureField(False).accumulate()[0], file.getGroupsNames()))
    print(f"{kind}: volume {seen[-1][0]:.4f}, groups {seen[-1][1]}")
sys.exit(0 if all(volume < 0 and not groups for volume, groups in seen) else "changed")
PY
