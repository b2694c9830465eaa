#!/usr/bin/env bash
# asammdf 8.8.28: a channel over crank angle loses its top dead center in a table, and shares one index with seconds.
# Expected: cylinder pressure sampled from -360 to 360 degrees (ASAM MDF 4, synchronization "angle") keeps its angles in
# MDF.to_dataframe, as MDF.get gives them, and is not mixed with a channel over time.
# What happens: the default time_from_zero=True shifts angles too (0 is then 360 degrees early), and channels over time
# are interpolated at angles, channels over angle at seconds, on one index. The unit written for the angle is "deg", while
# the standard asks for radians.
# Output seen:
#   MDF.get: [-360.0, 0.0, 360.0] deg
#   table of p: [0.0, 360.0, 720.0]
#   table of p and n: [0.0, 360.0, 367.0, 367.5, 720.0]
set -euo pipefail
folder=$(mktemp -d); trap 'rm -rf "$folder"' EXIT; cd "$folder"
python3 -m venv venv && venv/bin/pip install -q asammdf==8.8.28 numpy==2.4.6 pandas==3.1.1
venv/bin/python - <<'PY'
import sys

import numpy as np
from asammdf import MDF, Signal

ANGLE, TIME = 2, 1  # synchronization types of ASAM MDF 4
record = MDF(version="4.10")
record.append(Signal(np.array([1.0, 60.0, 1.0]), np.array([-360.0, 0.0, 360.0]), name="p", master_metadata=("a", ANGLE)))
record.append(Signal(np.array([1500.0, 1501.0]), np.array([7.0, 7.5]), name="n", master_metadata=("t", TIME)))
unit = record.groups[0].channels[0].unit
pressure, mixed = record.to_dataframe(["p"]).index.tolist(), record.to_dataframe(["p", "n"]).index.tolist()
print("MDF.get:", record.get("p").timestamps.tolist(), unit)
print("table of p:", pressure)
print("table of p and n:", mixed)
sys.exit(0 if pressure == [0, 360, 720] and mixed == [0, 360, 367, 367.5, 720] and unit == "deg" else "changed")
PY
