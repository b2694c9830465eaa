#!/usr/bin/env bash
# openTorsion 0.3.2: Assembly.vibratory_torque leaves out the torque of the shaft's own damper, and its total is no peak.
# Expected: the torque in a shaft is (k + i w c) times its twist, and the total is the largest torque over the cycle.
# What happens: k times the twist alone; the total is the sum of the amplitudes of all frequencies, whatever their phases.
# Two disks of 1 kg m2 on a shaft of 10 kN m/rad and 100 N m s/rad, 10 N m at 100 and at 200 rad/s:
# Output seen:
#   returned 4.472 and 2.236 N m, (k + i w c) twist 6.325 and 5.000 N m
#   returned total 6.708 N m, largest torque over the cycle 11.276 N m
set -euo pipefail
folder=$(mktemp -d); trap 'rm -rf "$folder"' EXIT; cd "$folder"
python3 -m venv venv && venv/bin/pip install -q opentorsion==0.3.2
venv/bin/python - <<'PY'
import sys

import numpy as np
import opentorsion

k, c, speeds = 1e4, 100.0, np.array([100.0, 200.0])
shaft = opentorsion.Assembly([opentorsion.Shaft(0, 1, k=k, c=c)], [opentorsion.Disk(0, 1.0), opentorsion.Disk(1, 1.0)])
excitation = opentorsion.PeriodicExcitation(2, speeds)
excitation.add_sines(0, speeds, [10.0, 10.0], [0.0, 0.0])
returned, total = shaft.vibratory_torque(excitation)
angles, _ = shaft.ss_response(excitation.U, speeds)
torque = (k + 1j * speeds * c) * (angles[0] - angles[1])
time = np.linspace(0, 2 * np.pi / 100, 20001)
peak = np.abs((torque @ np.exp(1j * np.outer(speeds, time))).real).max()
print("returned {:.3f} and {:.3f} N m, (k + i w c) twist {:.3f} and {:.3f} N m".format(*np.abs(returned[0]), *np.abs(torque)))
print(f"returned total {total[0]:.3f} N m, largest torque over the cycle {peak:.3f} N m")
sys.exit(0 if np.allclose(returned[0], k * (angles[0] - angles[1])) and not np.isclose(total[0], peak) else "changed")
PY
