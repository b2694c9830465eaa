#!/usr/bin/env bash
# OpenSeesPy 3.7.1.2: a beam with mass has no moment of inertia about its own axis, unless its mass is consistent.
# Expected: "-mass" gives a shaft between two disks its mass and with it its polar inertia rho J L; -cMass changes how
# it is spread over the nodes.
# What happens: the default puts translations alone on the nodes, so that the shaft turns without inertia, in silence
# and however finely it is divided. With -cMass its inertia is there.
# Output seen (one end held, disk as heavy in rotation as the shaft; frequency over that of the exact equation):
#   default 1.162, -cMass 1.000
set -euo pipefail
folder=$(mktemp -d); trap 'rm -rf "$folder"' EXIT; cd "$folder"
python3 -m venv venv && venv/bin/pip install -q openseespy==3.7.1.2
venv/bin/python - <<'PY'
import math
import sys

import openseespy.opensees as ops

LENGTH, DIAMETER, DENSITY, YOUNG, SHEAR, ELEMENTS = 1.0, 0.1, 7850.0, 2.1e11, 8e10, 10
area, bending = math.pi * DIAMETER**2 / 4, math.pi * DIAMETER**4 / 64
polar = 2 * bending
exact = 0.8603336 / LENGTH * math.sqrt(SHEAR / DENSITY)  # x tan x = 1: shaft and disk of the same inertia


def torsion(*mass):
    ops.wipe()
    ops.model("basic", "-ndm", 3, "-ndf", 6)
    ops.geomTransf("Linear", 1, 0, 0, 1)
    for node in range(ELEMENTS + 1):
        ops.node(node, LENGTH * node / ELEMENTS, 0, 0)
        ops.fix(node, 1, 1, 1, int(node == 0), 1, 1)
        ops.mass(node, 0, 0, 0, 1e-9, 0, 0)
    for node in range(ELEMENTS):
        ops.element("elasticBeamColumn", node, node, node + 1, area, YOUNG, SHEAR, polar, bending, bending, 1, *mass)
    ops.mass(ELEMENTS, 0, 0, 0, DENSITY * polar * LENGTH, 0, 0)
    return math.sqrt(ops.eigen(1)[0])


default = torsion("-mass", DENSITY * area) / exact
consistent = torsion("-mass", DENSITY * area, "-cMass") / exact
print(f"default {default:.3f}, -cMass {consistent:.3f}")
sys.exit(0 if abs(default - 1.162) < 0.002 and abs(consistent - 1) < 0.002 else "changed")
PY
