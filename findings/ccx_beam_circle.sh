#!/usr/bin/env bash
# CalculiX 2.20 (Debian calculix-ccx 2.20-1): *BEAM SECTION, SECTION=CIRC takes diameters where Abaqus takes the radius.
# Expected: 0.1 on the data line is the radius of the shaft, as in Abaqus, whose input language this is.
# What happens: it is the diameter (a second number makes an ellipse): a deck that is right for Abaqus is 16 times too soft.
# Output seen (cantilever of length 10, modulus 1e9, tip force 1, F L^3 / 3 E I by beam theory):
#   deflection 6.9520E-02; radius 0.1 would give 4.2441E-03, diameter 0.1 6.7906E-02
set -euo pipefail
folder=$(mktemp -d); trap 'rm -rf "$folder"' EXIT; cd "$folder"
apt-get download -qq -o APT::Sandbox::User=root calculix-ccx=2.20-1 libspooles2.2=2.2-14 libarpack2=3.8.0-3 \
  libblas3=3.11.0-2 liblapack3=3.11.0-2 libgfortran5=12.2.0-14+deb12u1 libquadmath0=12.2.0-14+deb12u1
for package in *.deb; do dpkg -x "$package" .; done
libraries=$folder/usr/lib/x86_64-linux-gnu; export LD_LIBRARY_PATH=$libraries:$libraries/blas:$libraries/lapack
cat > beam.inp <<DECK
*NODE
$(awk 'BEGIN { for (i = 0; i <= 20; i++) print i + 1 ", " i / 2 ", 0, 0" }')
*NSET, NSET=TIP
21
*ELEMENT, TYPE=B32R, ELSET=E
$(awk 'BEGIN { for (i = 1; i <= 10; i++) print i ", " 2 * i - 1 ", " 2 * i ", " 2 * i + 1 }')
*MATERIAL, NAME=M
*ELASTIC
1.E9, 0.
*BEAM SECTION, ELSET=E, MATERIAL=M, SECTION=CIRC
0.1
0., 0., 1.
*BOUNDARY
1, 1, 6
*STEP
*STATIC
*CLOAD
21, 2, 1.
*NODE PRINT, NSET=TIP
U
*END STEP
DECK
usr/bin/ccx beam > beam.log && ! grep -e WARNING -e ERROR beam.log
awk '$1 == 21 {
  radius = 1000 / (3e9 * atan2(0, -1) * 0.1^4 / 4)
  printf "deflection %.4E; radius 0.1 would give %.4E, diameter 0.1 %.4E\n", $3, radius, 16 * radius
  exit !($3 > 15 * radius && $3 < 17 * radius)
}' beam.dat
