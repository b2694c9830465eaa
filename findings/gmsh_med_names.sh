#!/usr/bin/env bash
# gmsh 4.15.2 reading a MED file pads the names of its groups to 80 characters.
# Expected: a physical name that went into the file comes back, and can be looked up.
# What happens: the name comes back with the fixed width of the format, filled with characters that a screen does not show.
# Two ways lead through .med with the same names and differ: MEDCoupling 9.15.0 gives the name itself.
# Output seen:
#   gmsh: 80 characters, MEDCoupling: ['journal']
set -euo pipefail
folder=$(mktemp -d); trap 'rm -rf "$folder"' EXIT; cd "$folder"
python3 -m venv venv && venv/bin/pip install -q gmsh==4.15.2 medcoupling==9.15.0
venv/bin/python - <<'PY'
import sys

import gmsh
import medcoupling

gmsh.initialize()
gmsh.option.setNumber("General.Verbosity", 1)
gmsh.model.occ.addBox(0, 0, 0, 1, 1, 1)
gmsh.model.occ.synchronize()
gmsh.model.addPhysicalGroup(3, [1], name="journal")
gmsh.model.mesh.generate(3)
gmsh.write("box.med")
gmsh.clear()
gmsh.merge("box.med")
length = len(gmsh.model.getPhysicalName(*gmsh.model.getPhysicalGroups()[0]))
names = list(medcoupling.MEDFileUMesh("box.med").getGroupsNames())
print(f"gmsh: {length} characters, MEDCoupling: {names}")
sys.exit(0 if length == 80 and names == ["journal"] else "changed")
PY
