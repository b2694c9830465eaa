#!/usr/bin/env bash
# Netgen 6.2.2608: a mesh read from gmsh leaves as Abaqus input with every element inside out, which CalculiX refuses.
# Expected: a tetrahedron of positive volume is written with positive volume, as Netgen's own meshes are.
# What happens: read_gmsh keeps gmsh's order of nodes, Netgen's own order is the mirrored one, and the export to
# "Abaqus Format" turns the order of each element. Inside NGSolve nothing shows it: integrals take the absolute value.
# Only "Gmsh2 Format" gives back what was read; CalculiX 2.20 (Debian calculix-ccx) stops with "nonpositive jacobian".
# Output seen (6 times the signed volume, by the order of the nodes in the file):
#   in the file read 1.0, exported to Abaqus -1.0, a mesh of Netgen's own exported 1.0
set -euo pipefail
folder=$(mktemp -d); trap 'rm -rf "$folder"' EXIT; cd "$folder"
python3 -m venv venv && venv/bin/pip install -q ngsolve==6.2.2608
cat > one.msh <<'MSH'
$MeshFormat
2.2 0 8
$EndMeshFormat
$PhysicalNames
2
2 1 "skin"
3 2 "steel"
$EndPhysicalNames
$Nodes
4
1 0 0 0
2 1 0 0
3 0 1 0
4 0 0 1
$EndNodes
$Elements
5
1 2 2 1 1 1 3 2
2 2 2 1 1 1 2 4
3 2 2 1 1 1 4 3
4 2 2 1 1 2 3 4
5 4 2 2 1 1 2 3 4
$EndElements
MSH
venv/bin/python - <<'PY'
import sys

import numpy as np
from netgen.csg import CSGeometry, OrthoBrick, Pnt
from netgen.read_gmsh import ReadGmsh


def signed_volume(path):
    nodes, elements, solids = {}, [], False
    for line in open(path):
        if line.startswith("*"):
            solids, points = "C3D4" in line, line.startswith("*Node")
        elif solids:
            elements.append([int(number) for number in line.split(",")[1:5]])
        elif points:
            number, *place = line.split(",")
            nodes[int(number)] = [float(value) for value in place]
    corners = np.array([[nodes[number] for number in element] for element in elements])
    return np.linalg.det(corners[:, 1:] - corners[:, :1])


read = ReadGmsh("one.msh")
read.Export("read.inp", "Abaqus Format")
brick = CSGeometry()
brick.Add(OrthoBrick(Pnt(0, 0, 0), Pnt(1, 1, 1)))
brick.GenerateMesh(maxh=1).Export("brick.inp", "Abaqus Format")
(exported,), own = signed_volume("read.inp"), signed_volume("brick.inp")
print(f"in the file read 1.0, exported to Abaqus {exported:.1f}, a mesh of Netgen's own exported {own.min():.1f}")
sys.exit(0 if exported == -1 and (own > 0).all() else "changed")
PY
