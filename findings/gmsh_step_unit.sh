#!/usr/bin/env bash
# gmsh 4.15.2: a STEP file in meters arrives in millimeters, and every STEP file it writes says millimeters.
# Expected: numbers of the file are kept, as for every other format that gmsh reads and writes.
# What happens: OpenCASCADE scales to millimeters on reading; a model built in meters (a unit cube) is written as a cube of
# 1 mm. Length unit of a model is thus m or mm by the way it came; Geometry.OCCTargetUnit="M" before reading keeps meters.
# Output seen:
#   written: SI_UNIT(.MILLI.,.METRE.)
#   cube of 1 in a file in meters: volume 1e+09
set -euo pipefail
folder=$(mktemp -d); trap 'rm -rf "$folder"' EXIT; cd "$folder"
python3 -m venv venv && venv/bin/pip install -q gmsh==4.15.2
venv/bin/python - <<'PY'
import pathlib
import re
import sys

import gmsh

gmsh.initialize()
gmsh.option.setNumber("General.Verbosity", 1)
gmsh.model.occ.addBox(0, 0, 0, 1, 1, 1)
gmsh.model.occ.synchronize()
gmsh.write("cube.step")
text = pathlib.Path("cube.step").read_text()
unit = re.search(r"SI_UNIT\(\S*,\.METRE\.\)", text).group()
pathlib.Path("meters.step").write_text(text.replace(unit, "SI_UNIT($,.METRE.)"))
gmsh.clear()
gmsh.model.occ.importShapes("meters.step")
volume = gmsh.model.occ.getMass(3, 1)
print("written:", unit)
print(f"cube of 1 in a file in meters: volume {volume:.3g}")
sys.exit(0 if "MILLI" in unit and abs(volume / 1e9 - 1) < 1e-9 else "changed")
PY
