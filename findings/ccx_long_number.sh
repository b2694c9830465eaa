#!/usr/bin/env bash
# CalculiX 2.20 (Debian calculix-ccx 2.20-1) reads only the first 20 characters of a number, in silence.
# Expected: 2.000000000000000e-03 (21 characters, written by "%.15e") is 0.002, or is refused as 22 characters are.
# What happens: the last digit of the exponent falls off, 2.000000000000000e-0 is 2: the tetrahedron is 1000 times as high
# with exit status 0 and no warning. Coordinates in metres written with 16 digits have such exponents.
# Output seen:
#   20 characters, 2.00000000000000e-03 : volume 3.333333E-04
#   21 characters, 2.000000000000000e-03: volume 3.333333E-01
set -euo pipefail
folder=$(mktemp -d); trap 'rm -rf "$folder"' EXIT; cd "$folder"
apt-get download -qq -o APT::Sandbox::User=root calculix-ccx=2.20-1 libspooles2.2=2.2-14 libarpack2=3.8.0-3 \
  libblas3=3.11.0-2 liblapack3=3.11.0-2 libgfortran5=12.2.0-14+deb12u1 libquadmath0=12.2.0-14+deb12u1
for package in *.deb; do dpkg -x "$package" .; done
libraries=$folder/usr/lib/x86_64-linux-gnu; export LD_LIBRARY_PATH=$libraries:$libraries/blas:$libraries/lapack
volume() {
  cat > one.inp <<DECK
*NODE, NSET=BASE
1, 0., 0., 0.
2, 1., 0., 0.
3, 0., 1., 0.
*NODE
4, 0., 0., $1
*ELEMENT, TYPE=C3D4, ELSET=E
1, 1, 2, 3, 4
*MATERIAL, NAME=M
*ELASTIC
1., 0.
*SOLID SECTION, ELSET=E, MATERIAL=M
*BOUNDARY
BASE, 1, 3
*STEP
*STATIC
*CLOAD
4, 3, 1.
*EL PRINT, ELSET=E, TOTALS=ONLY
EVOL
*END STEP
DECK
  usr/bin/ccx one > one.log && ! grep -e WARNING -e ERROR one.log && awk 'NF == 1 { print $1 }' one.dat
}
short=$(volume 2.00000000000000e-03) long=$(volume 2.000000000000000e-03)
echo "20 characters, 2.00000000000000e-03 : volume $short"
echo "21 characters, 2.000000000000000e-03: volume $long"
[ "$short" = 3.333333E-04 ] && [ "$long" = 3.333333E-01 ]
