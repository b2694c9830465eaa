#!/usr/bin/env bash
# gmsh 4.15.2: Geometry.OCCScaling drops the names of the solids of a STEP file; the option that keeps them cannot be undone.
# Expected: both ways to read millimeters as meters give the same model, and OCCTargetUnit="" is the state before it was set.
# What happens: with OCCScaling=1e-3 every name is empty. With OCCTargetUnit="M" names stay, but M holds for every later
# file of the process, through OCCTargetUnit="" and even through finalize and initialize; only "MM" leads back.
# Output seen (box of 10 x 20 x 30 mm):
#   as it is          'Shapes/Open CASCADE STEP translator 7.8 1' 6e+03
#   OCCScaling 1e-3   '' 6e-06
#   target unit M     'Shapes/Open CASCADE STEP translator 7.8 1' 6e-06
#   target unit empty 'Shapes/Open CASCADE STEP translator 7.8 1' 6e-06
#   a new session     'Shapes/Open CASCADE STEP translator 7.8 1' 6e-06
set -euo pipefail
folder=$(mktemp -d); trap 'rm -rf "$folder"' EXIT; cd "$folder"
python3 -m venv venv && venv/bin/pip install -q gmsh==4.15.2
venv/bin/python - <<'PY'
import sys

import gmsh


def read(words):
    gmsh.clear()
    gmsh.model.occ.importShapes("box.step")
    gmsh.model.occ.synchronize()
    name, volume = gmsh.model.getEntityName(3, 1), gmsh.model.occ.getMass(3, 1)
    print(f"{words:17} {name!r} {volume:.3g}")
    return bool(name), volume > 1


gmsh.initialize()
gmsh.option.setNumber("General.Verbosity", 1)
gmsh.model.occ.addBox(0, 0, 0, 10, 20, 30)
gmsh.model.occ.synchronize()
gmsh.write("box.step")
seen = [read("as it is")]
gmsh.option.setNumber("Geometry.OCCScaling", 1e-3)
seen.append(read("OCCScaling 1e-3"))
gmsh.option.setNumber("Geometry.OCCScaling", 1)
for unit in ("M", ""):
    gmsh.option.setString("Geometry.OCCTargetUnit", unit)
    seen.append(read("target unit " + (unit or "empty")))
gmsh.finalize()
gmsh.initialize()
gmsh.option.setNumber("General.Verbosity", 1)
seen.append(read("a new session"))
sys.exit(0 if seen == [(True, True), (False, False), (True, False), (True, False), (True, False)] else "changed")
PY
