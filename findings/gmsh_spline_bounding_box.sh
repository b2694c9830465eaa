#!/usr/bin/env bash
# gmsh 4.15.2: the bounding box of a solid that an affine map made a spline is up to twice as wide as the solid.
# Expected: model.getBoundingBox holds the solid tightly, within 1e-7, as for a cylinder.
# What happens: affineTransform turns analytic faces into B-splines, even by the identity, and the box is that of the
# control points. The option Geometry.OCCBoundsUseStl=1, after a mesh, gives the size.
# Output seen (x of a cylinder of radius 10 about z):
#   as made -10.000 to 10.000, after the identity -20.000 to 10.000
set -euo pipefail
folder=$(mktemp -d); trap 'rm -rf "$folder"' EXIT; cd "$folder"
python3 -m venv venv && venv/bin/pip install -q gmsh==4.15.2
venv/bin/python - <<'PY'
import sys

import gmsh

gmsh.initialize()
gmsh.option.setNumber("General.Verbosity", 1)
occ = gmsh.model.occ
occ.addCylinder(0, 0, 0, 0, 0, 50, 10, 1)
occ.synchronize()
made = gmsh.model.getBoundingBox(3, 1)
occ.affineTransform([(3, 1)], [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0])
occ.synchronize()
mapped = gmsh.model.getBoundingBox(3, 1)
print(f"as made {made[0]:.3f} to {made[3]:.3f}, after the identity {mapped[0]:.3f} to {mapped[3]:.3f}")
sys.exit(0 if abs(made[0] + 10) < 1e-6 and mapped[0] < -15 else "changed")
PY
