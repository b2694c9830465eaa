#!/usr/bin/env bash
# openTorsion 0.3.2: PeriodicExcitation.add_sines ignores the frequencies that stand beside its amplitudes.
# Expected: add_sines(node, 200 rad/s, 5 N m, 0) puts 5 N m into the column of 200 rad/s, and a frequency that the
# excitation does not have is refused.
# What happens: amplitudes go to the columns by position: 5 N m at 200 rad/s act at 100 rad/s, the first of the list.
# Two cylinders or two harmonics given in another order exchange their torques.
# Output seen:
#   frequencies [100. 200.] amplitudes [5. 0.]
set -euo pipefail
folder=$(mktemp -d); trap 'rm -rf "$folder"' EXIT; cd "$folder"
python3 -m venv venv && venv/bin/pip install -q opentorsion==0.3.2
venv/bin/python - <<'PY'
import sys

import numpy as np
import opentorsion

excitation = opentorsion.PeriodicExcitation(2, np.array([100.0, 200.0]))
excitation.add_sines(0, [200.0], [5.0], [0.0])
amplitudes = np.abs(excitation.U[0])
print("frequencies", excitation.omegas, "amplitudes", amplitudes)
sys.exit(0 if amplitudes.tolist() == [5.0, 0.0] else "changed")
PY
