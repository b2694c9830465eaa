#!/usr/bin/env bash
# gmsh 4.15.2 writes Nastran files (.bdf) with 3 to 7 digits per coordinate by default.
# Expected: a mesh written and read back is the same mesh to double precision, as with .msh, .unv or .med.
# What happens: Mesh.BdfFieldFormat is 1, the 8-character field, and sign, point and exponent take of the 8. A part in meters
# at some distance from the origin loses most: nodes move by up to half a unit of the last digit. Format 2 has 16 characters.
# Output seen (one corner at x = 0.0123456789, y = -0.0043219876):
#   BdfFieldFormat 1: 0.012346 -0.00432
#   BdfFieldFormat 2: 0.0123456789 -0.0043219876
set -euo pipefail
folder=$(mktemp -d); trap 'rm -rf "$folder"' EXIT; cd "$folder"
python3 -m venv venv && venv/bin/pip install -q gmsh==4.15.2
venv/bin/python - <<'PY'
import sys

import gmsh

gmsh.initialize()
gmsh.option.setNumber("General.Verbosity", 1)
corners = {}
for form in (gmsh.option.getNumber("Mesh.BdfFieldFormat"), 2):
    gmsh.clear()
    point = gmsh.model.geo.addPoint(0.0123456789, -0.0043219876, 0)
    gmsh.model.geo.addLine(point, gmsh.model.geo.addPoint(1, 1, 1))
    gmsh.model.geo.synchronize()
    gmsh.model.mesh.generate(1)
    gmsh.option.setNumber("Mesh.BdfFieldFormat", form)
    gmsh.write("line.bdf")
    gmsh.clear()
    gmsh.merge("line.bdf")
    corners[form] = [float(f"{value:.12g}") for value in gmsh.model.mesh.getNode(1)[0][:2]]
    print(f"BdfFieldFormat {form:.0f}:", *corners[form])
sys.exit(0 if corners[1] == [0.012346, -0.00432] and abs(corners[2][1] + 0.0043219876) < 1e-12 else "changed")
PY
