#!/usr/bin/env bash
# CalculiX 2.20 (Debian calculix-ccx 2.20-1): *FREQUENCY of a small model prints zeros as natural frequencies and ends with 0.
# Expected: three of the six modes of a chain of six masses, or an exit status that stops the caller.
# What happens: the Lanczos method needs more room than there are degrees of freedom (info=-3 in the log); the table of
# eigenvalues is printed all the same, all zero, as for rigid-body modes, and the exit status is 0. One mode is found.
# Output seen (six masses of 1 on springs of 100, fixed at one end: 2.4107 and 7.0921 rad/s exactly):
#   1 mode : exit 0, first frequency 0.2410734E+01 rad/s
#   3 modes: exit 0, first frequency 0.0000000E+00 rad/s
set -euo pipefail
folder=$(mktemp -d); trap 'rm -rf "$folder"' EXIT; cd "$folder"
apt-get download -qq -o APT::Sandbox::User=root calculix-ccx=2.20-1 libspooles2.2=2.2-14 libarpack2=3.8.0-3 \
  libblas3=3.11.0-2 liblapack3=3.11.0-2 libgfortran5=12.2.0-14+deb12u1 libquadmath0=12.2.0-14+deb12u1
for package in *.deb; do dpkg -x "$package" .; done
libraries=$folder/usr/lib/x86_64-linux-gnu; export LD_LIBRARY_PATH=$libraries:$libraries/blas:$libraries/lapack
chain() {
  cat > chain.inp <<DECK
*NODE, NSET=ALL
$(awk 'BEGIN { for (i = 1; i <= 7; i++) print i ", " i ", 0, 0" }')
*ELEMENT, TYPE=SPRINGA, ELSET=SPRINGS
$(awk 'BEGIN { for (i = 1; i <= 6; i++) print i ", " i ", " i + 1 }')
*SPRING, ELSET=SPRINGS

100.
*ELEMENT, TYPE=MASS, ELSET=MASSES
$(awk 'BEGIN { for (i = 2; i <= 7; i++) print 10 + i ", " i }')
*MASS, ELSET=MASSES
1.
*BOUNDARY
1, 1, 3
ALL, 2, 3
*STEP
*FREQUENCY
$1
*END STEP
DECK
  status=0; usr/bin/ccx chain > chain.log || status=$?
  echo "exit $status, first frequency $(awk '$1 == 1 { print $3; exit }' chain.dat) rad/s"
}
one=$(chain 1) three=$(chain 3)
echo "1 mode : $one"
echo "3 modes: $three"
[[ $one = "exit 0, first frequency 0.241"* && $three = "exit 0, first frequency 0.0000000E+00"* ]]
