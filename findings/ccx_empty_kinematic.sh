#!/usr/bin/env bash
# CalculiX 2.20 (Debian calculix-ccx 2.20-1): *KINEMATIC without a data line couples nothing, in silence.
# Expected: all degrees of freedom of the face follow the reference node, as in Abaqus, whose input language this is,
# or an error, since a force acts on a node of no element.
# What happens: no equation is made and the force is lost: every displacement is 0, exit status 0, no warning.
# Output seen (block of stiffness 1000 pulled with 1):
#   data line "1, 3": face moves 1.000000E-03
#   no data line    : face moves 0.000000E+00
set -euo pipefail
folder=$(mktemp -d); trap 'rm -rf "$folder"' EXIT; cd "$folder"
apt-get download -qq -o APT::Sandbox::User=root calculix-ccx=2.20-1 libspooles2.2=2.2-14 libarpack2=3.8.0-3 \
  libblas3=3.11.0-2 liblapack3=3.11.0-2 libgfortran5=12.2.0-14+deb12u1 libquadmath0=12.2.0-14+deb12u1
for package in *.deb; do dpkg -x "$package" .; done
libraries=$folder/usr/lib/x86_64-linux-gnu; export LD_LIBRARY_PATH=$libraries:$libraries/blas:$libraries/lapack
face() {
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
*KINEMATIC
$1*STEP
*STATIC
*CLOAD
9, 3, 1.
*NODE PRINT, NSET=TOP
U
*END STEP
DECK
  usr/bin/ccx block > block.log && ! grep -e WARNING -e ERROR block.log && awk '$1 == 5 { print $4 }' block.dat
}
with=$(face $'1, 3\n') without=$(face "")
echo "data line \"1, 3\": face moves $with"
echo "no data line    : face moves $without"
[ "$with" = 1.000000E-03 ] && [ "$without" = 0.000000E+00 ]
