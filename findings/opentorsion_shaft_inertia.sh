#!/usr/bin/env bash
# openTorsion 0.3.2: Shaft(k=..., I=...) has six times the moment of inertia it is given.
# Expected: I is, in the words of the docstring, the "Moment of inertia of the shaft [kgm^2]", as with a shaft given by its
# geometry, whose element holds rho J L in all.
# What happens: I takes the place of rho J L / 6 in the consistent matrix [[2, 1], [1, 2]], which holds 6 I.
# A free shaft of I = 6 turned as a whole, without any other inertia: 36 kg m2.
# Output seen:
#   geometry: 0.078540 kg m2 of 0.078540; I = 6: 36.000000 kg m2
set -euo pipefail
folder=$(mktemp -d); trap 'rm -rf "$folder"' EXIT; cd "$folder"
python3 -m venv venv && venv/bin/pip install -q opentorsion==0.3.2
venv/bin/python - <<'PY'
import math
import sys

import opentorsion

drawn = opentorsion.Shaft(0, 1, L=1000, odl=100, rho=8000).M().sum()
given = opentorsion.Shaft(0, 1, k=1e6, I=6.0).M().sum()
print(f"geometry: {drawn:.6f} kg m2 of {8000 * math.pi / 32 * 0.1**4:.6f}; I = 6: {given:.6f} kg m2")
sys.exit(0 if math.isclose(given, 36.0) else "changed")
PY
