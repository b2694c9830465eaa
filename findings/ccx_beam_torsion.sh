#!/usr/bin/env bash
# CalculiX 2.20 (Debian calculix-ccx 2.20-1): a square beam is 19 % too stiff in torsion, however finely it is divided.
# Expected: the torsional stiffness of a beam element is G J with the torsion constant of its section, 0.1406 a^4.
# What happens: a beam B31 becomes one solid element over its section, which cannot warp as a bar does, a square not at all:
# G times the polar moment of area a^4 / 6. The manual tells of the expansion, no warning tells of the stiffness.
# Output seen (2 x 2, length 10, G 1e5, torque 1000):
#   twist 0.0375 rad; G J 0.0445 rad, polar moment 0.0375 rad
set -euo pipefail
folder=$(mktemp -d); trap 'rm -rf "$folder"' EXIT; cd "$folder"
apt-get download -qq -o APT::Sandbox::User=root calculix-ccx=2.20-1 libspooles2.2=2.2-14 libarpack2=3.8.0-3 \
  libblas3=3.11.0-2 liblapack3=3.11.0-2 libgfortran5=12.2.0-14+deb12u1 libquadmath0=12.2.0-14+deb12u1
for package in *.deb; do dpkg -x "$package" .; done
libraries=$folder/usr/lib/x86_64-linux-gnu; export LD_LIBRARY_PATH=$libraries:$libraries/blas:$libraries/lapack
cat > beam.inp <<DECK
*NODE
$(awk 'BEGIN { for (i = 0; i <= 20; i++) print i + 1 ", " i / 2 ", 0, 0" }')
*ELEMENT, TYPE=B31, ELSET=E
$(awk 'BEGIN { for (i = 1; i <= 20; i++) print i ", " i ", " i + 1 }')
*MATERIAL, NAME=M
*ELASTIC
2.5E5, 0.25
*BEAM SECTION, ELSET=E, MATERIAL=M, SECTION=RECT
2., 2.
0., 0., 1.
*BOUNDARY
1, 1, 6
*STEP
*STATIC
*CLOAD
21, 4, 1000.
*NODE FILE, OUTPUT=3D
U
*END STEP
DECK
usr/bin/ccx beam > beam.log && ! grep -e WARNING -e ERROR beam.log
# fixed columns of 12 characters; twist from any corner of the end, (y uz - z uy) / (y^2 + z^2)
awk 'function field(k) { return substr($0, 14 + 12 * k, 12) + 0 }
/^ -4  DISP/ { moved = 1 }
/^ -1/ && !moved && field(0) > 9.9 { node = substr($0, 4, 10); y = field(1); z = field(2) }
/^ -1/ && moved && substr($0, 4, 10) == node { twist = (y * field(2) - z * field(1)) / (y^2 + z^2) }
END {
  constant = 1e4 / (1e5 * 0.1406 * 16); polar = 1e4 / (1e5 * 16 / 6)
  printf "twist %.4f rad; G J %.4f rad, polar moment %.4f rad\n", twist, constant, polar
  exit !(twist > 0.99 * polar && twist < 1.01 * polar)
}' beam.frd
