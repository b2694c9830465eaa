#!/usr/bin/env bash
# CalculiX 2.20 (Debian calculix-ccx 2.20-1): the reference node of a *DISTRIBUTING coupling never moves.
# Expected: its printed displacement is the mean displacement of the face (RBE3), so that displacement over force is the
# compliance of what it holds.
# What happens: the force is spread rightly, the node prints 0. It carries loads only; the mean has to be taken by hand.
# Output seen (block of stiffness 1000 pulled with 1):
#   nodes of the face 1.000000E-03, reference node 0.000000E+00
set -euo pipefail
folder=$(mktemp -d); trap 'rm -rf "$folder"' EXIT; cd "$folder"
apt-get download -qq -o APT::Sandbox::User=root calculix-ccx=2.20-1 libspooles2.2=2.2-14 libarpack2=3.8.0-3 \
  libblas3=3.11.0-2 liblapack3=3.11.0-2 libgfortran5=12.2.0-14+deb12u1 libquadmath0=12.2.0-14+deb12u1
for package in *.deb; do dpkg -x "$package" .; done
libraries=$folder/usr/lib/x86_64-linux-gnu; export LD_LIBRARY_PATH=$libraries:$libraries/blas:$libraries/lapack
cat > block.inp <<DECK
*NODE, NSET=BOTTOM
1, 0, 0, 0
2, 1, 0, 0
3, 1, 1, 0
4, 0, 1, 0
*NODE, NSET=TOP
5, 0, 0, 1
6, 1, 0, 1
7, 1, 1, 1
8, 0, 1, 1
*NODE, NSET=REFERENCE
9, .5, .5, 1
10, .5, .5, 1
*ELEMENT, TYPE=C3D8, ELSET=E
1, 1, 2, 3, 4, 5, 6, 7, 8
*MATERIAL, NAME=M
*ELASTIC
1000., 0.
*SOLID SECTION, ELSET=E, MATERIAL=M
*BOUNDARY
BOTTOM, 1, 3
*SURFACE, NAME=FACE, TYPE=ELEMENT
E, S2
*COUPLING, CONSTRAINT NAME=C, SURFACE=FACE, REF NODE=9
*DISTRIBUTING
1, 3
*STEP
*STATIC
*CLOAD
9, 3, 1.
*NODE PRINT, NSET=TOP
U
*NODE PRINT, NSET=REFERENCE
U
*END STEP
DECK
usr/bin/ccx block > block.log && ! grep -e WARNING -e ERROR block.log
face=$(awk '$1 >= 5 && $1 <= 8 { print $4 }' block.dat | sort -u) reference=$(awk '$1 == 9 { print $4 }' block.dat)
echo "nodes of the face $face, reference node $reference"
[ "$face" = 1.000000E-03 ] && [ "$reference" = 0.000000E+00 ]
