#!/usr/bin/env bash
# ROSS 2.3.0: the coefficients of a bearing table do not go through the table, and stiffness turns negative between and past it.
# Expected: "Values for each parameter will be interpolated for the speed": a value of the table is given back, and between
# two values nothing leaves their range.
# What happens: the table goes into a smoothing cubic spline whose bound is absolute, one unit of the coefficient squared
# per row. Small numbers (added masses in kg) are replaced by one cubic through all rows; large ones are met, but overshoot.
# Output seen:
#   mass of the table [0. 0. 0. 1. 1. 1.] kg, given back [ 0.024 -0.119  0.238  0.762  1.119  0.976]
#   stiffness 1e6 at 0 and 100 rad/s, given at 50 rad/s -1.250e+06 N/m
set -euo pipefail
folder=$(mktemp -d); trap 'rm -rf "$folder"' EXIT; cd "$folder"
python3 -m venv venv && venv/bin/pip install -q ross-rotordynamics==2.3.0 plotly==5.24.1 pint==0.25.3 numpy==2.4.6 scipy==1.17.1
venv/bin/python - <<'PY'
import sys

import numpy as np
import ross

speeds = np.linspace(0.0, 500.0, 6)
masses = np.array([0.0, 0.0, 0.0, 1.0, 1.0, 1.0])
bearing = ross.BearingElement(n=0, kxx=1e8 + 0 * speeds, cxx=1e3 + 0 * speeds, mxx=masses, frequency=speeds)
back = np.array([bearing.M(speed)[0, 0] for speed in speeds])
steep = ross.BearingElement(n=0, kxx=[1e6, 1e6, 1e7, 1e7], cxx=[1e3] * 4, frequency=[0.0, 100.0, 200.0, 300.0])
between = steep.K(50.0)[0, 0]
print("mass of the table", masses, "kg, given back", back.round(3))
print(f"stiffness 1e6 at 0 and 100 rad/s, given at 50 rad/s {between:.3e} N/m")
sys.exit(0 if np.abs(back - masses).max() > 0.05 and between < 0 else "changed")
PY
