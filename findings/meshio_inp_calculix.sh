#!/usr/bin/env bash
# meshio 5.3.5 writes 10-node tetrahedra into .inp so that CalculiX 2.20 (Debian calculix-ccx 2.20-1) cannot read them.
# Expected: element C3D10 and numbers that the solver reads, as gmsh writes them; triangles that mark a face are no parts.
# What happens: of the Abaqus names for tetra10 the last one of a table is taken, the hybrid C3D10MH, which CalculiX does
# not know; numbers have 22 characters, of which it takes 20; triangle6 becomes CPE6, a plane strain solid.
# Output seen:
#   *ELEMENT, TYPE=C3D10MH
#   *ELEMENT, TYPE=CPE6
#   longest number 22 characters
#   CalculiX: *ERROR reading *NODE. Card image:
set -euo pipefail
folder=$(mktemp -d); trap 'rm -rf "$folder"' EXIT; cd "$folder"
python3 -m venv venv && venv/bin/pip install -q meshio==5.3.5 numpy==2.4.6
apt-get download -qq -o APT::Sandbox::User=root calculix-ccx=2.20-1 libspooles2.2=2.2-14 libarpack2=3.8.0-3 \
  libblas3=3.11.0-2 liblapack3=3.11.0-2 libgfortran5=12.2.0-14+deb12u1 libquadmath0=12.2.0-14+deb12u1
for package in *.deb; do dpkg -x "$package" .; done
libraries=$folder/usr/lib/x86_64-linux-gnu; export LD_LIBRARY_PATH=$libraries:$libraries/blas:$libraries/lapack
venv/bin/python - <<'PY'
import re
import subprocess
import sys
from pathlib import Path

import meshio
import numpy as np

corners = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]])
middles = [(corners[i] + corners[j]) / 2 for i, j in ((0, 1), (1, 2), (0, 2), (0, 3), (1, 3), (2, 3))]
points = np.vstack([corners, middles])
cells = [("tetra10", np.arange(10)[None]), ("triangle6", np.array([[0, 2, 1, 6, 5, 4]]))]
meshio.Mesh(points, cells).write("one.inp")
text = Path("one.inp").read_text()
kinds = re.findall(r"\*ELEMENT.*", text)
longest = max(len(number) for number in re.findall(r"-?\d\.\d+e[+-]\d+", text))
log = subprocess.run(["usr/bin/ccx", "one"], capture_output=True, text=True).stdout
error = next((line.strip() for line in log.splitlines() if "ERROR" in line), "no error")
print(*kinds, f"longest number {longest} characters", f"CalculiX: {error}", sep="\n")
sys.exit(0 if "C3D10MH" in kinds[0] and "CPE6" in kinds[1] and longest > 20 and "ERROR" in error else "changed")
PY
