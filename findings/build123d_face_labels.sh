#!/usr/bin/env bash
# build123d 0.13.0 writes the label of a solid into a STEP file, but not the labels of its faces.
# Expected: label is a property of every shape, so that a face labeled "pin" arrives as a named face, as the names of
# Assembly.addSubshape of CadQuery 2.8.0 do.
# What happens: every ADVANCED_FACE has an empty name, in silence; what a mesher or solver should find by name is gone.
# Output seen:
#   build123d: solids named journal, faces named none; CadQuery: faces named pin
set -euo pipefail
folder=$(mktemp -d); trap 'rm -rf "$folder"' EXIT; cd "$folder"
python3 -m venv b && b/bin/pip install -q build123d==0.13.0
python3 -m venv c && c/bin/pip install -q cadquery==2.8.0
b/bin/python - <<'PY'
from build123d import Cylinder, export_step

journal = Cylinder(10, 50)
journal.label = "journal"
for face in journal.faces():
    face.label = "pin"
export_step(journal, "b.step")
PY
c/bin/python - <<'PY'
import cadquery

journal = cadquery.Workplane().cylinder(50, 10)
shaft = cadquery.Assembly(name="shaft")
shaft.add(journal, name="journal")
shaft.addSubshape(journal.faces(">Z").val(), name="pin")
shaft.export("c.step")
PY
python3 - <<'PY'
import re
import sys


def names(path, entity):
    return ", ".join(sorted(set(re.findall(entity + r"\('([^']+)'", open(path).read())))) or "none"


solids, lost, kept = names("b.step", "PRODUCT"), names("b.step", "ADVANCED_FACE"), names("c.step", "ADVANCED_FACE")
print(f"build123d: solids named {solids}, faces named {lost}; CadQuery: faces named {kept}")
sys.exit(0 if (solids, lost, kept) == ("journal", "none", "pin") else "changed")
PY
