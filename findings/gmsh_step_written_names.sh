#!/usr/bin/env bash
# gmsh 4.15.2 reads the names of solids from a STEP file but writes none of its own.
# Expected: a name that model.setEntityName gave comes back from the STEP file, as names given by a CAD program do.
# What happens: the file names all products after the translator, and reading gives every solid that name with a number:
# solids found by name, the crankshaft and the flywheel of one file, are found no more after a round through gmsh.
# Output seen:
#   set ['web', 'pin'], read ['Shapes/Open CASCADE STEP translator 7.8 1/1/Open CASCADE STEP translator 7.8 1.1',
#   'Shapes/Open CASCADE STEP translator 7.8 1/2/Open CASCADE STEP translator 7.8 1.2']
set -euo pipefail
folder=$(mktemp -d); trap 'rm -rf "$folder"' EXIT; cd "$folder"
python3 -m venv venv && venv/bin/pip install -q gmsh==4.15.2
venv/bin/python - <<'PY'
import sys

import gmsh

gmsh.initialize()
gmsh.option.setNumber("General.Verbosity", 1)
for tag, name in ((1, "web"), (2, "pin")):
    gmsh.model.occ.addBox(10 * tag, 0, 0, 1, 2, 3, tag)
    gmsh.model.occ.synchronize()
    gmsh.model.setEntityName(3, tag, name)
given = [gmsh.model.getEntityName(*solid) for solid in gmsh.model.getEntities(3)]
gmsh.write("two.step")
gmsh.clear()
gmsh.model.occ.importShapes("two.step")
gmsh.model.occ.synchronize()
read = [gmsh.model.getEntityName(*solid) for solid in gmsh.model.getEntities(3)]
print(f"set {given}, read {read}")
sys.exit(0 if given == ["web", "pin"] and len(read) == 2 and not set(given) & set(read) else "changed")
PY
