#!/usr/bin/env bash
# CalculiX 2.20 (Debian calculix-ccx 2.20-1): the moment on a *RIGID BODY is a force on its ROT NODE.
# Expected: "9, 6, 1." (degree of freedom 6 of REF NODE 9) is the moment about z, as in Abaqus and as in CalculiX itself
# for *COUPLING with *DISTRIBUTING.
# What happens: that load is dropped without a warning. Direction 3 of the ROT NODE is the moment about z, and its
# displacement is the angle in rad.
# Output seen (twisted block):
#   *CLOAD 9, 6, 1. : corner moves 0.000000E+00, ROT NODE 0.000000E+00
#   *CLOAD 10, 3, 1.: corner moves 6.000000E-03, ROT NODE 1.200000E-02
set -euo pipefail
folder=$(mktemp -d); trap 'rm -rf "$folder"' EXIT; cd "$folder"
apt-get download -qq -o APT::Sandbox::User=root calculix-ccx=2.20-1 libspooles2.2=2.2-14 libarpack2=3.8.0-3 \
  libblas3=3.11.0-2 liblapack3=3.11.0-2 libgfortran5=12.2.0-14+deb12u1 libquadmath0=12.2.0-14+deb12u1
for package in *.deb; do dpkg -x "$package" .; done
libraries=$folder/usr/lib/x86_64-linux-gnu; export LD_LIBRARY_PATH=$libraries:$libraries/blas:$libraries/lapack
twist() {
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
*RIGID BODY, NSET=TOP, REF NODE=9, ROT NODE=10
*STEP
*STATIC
*CLOAD
$1
*NODE PRINT, NSET=TOP
U
*NODE PRINT, NSET=REFERENCE
U
*END STEP
DECK
  usr/bin/ccx block > block.log && ! grep -e WARNING -e ERROR block.log
  awk '$1 == 5 { corner = $2 } $1 == 10 { print "corner moves " corner ", ROT NODE " $4 }' block.dat
}
reference=$(twist "9, 6, 1.") rotation=$(twist "10, 3, 1.")
echo "*CLOAD 9, 6, 1. : $reference"
echo "*CLOAD 10, 3, 1.: $rotation"
[[ $reference = *0.000000E+00*0.000000E+00 && $rotation = *6.000000E-03*1.200000E-02 ]]
