#!/usr/bin/env bash
# asammdf 8.8.28: resampling goes on past the end of a channel, and in steps or straight lines by the type of its numbers.
# Expected: where a channel has ended a common table has gaps, and two channels of the same values are interpolated alike.
# What happens: the last value is held as long as any other channel lasts, so a mean over the table counts it many times
# (interpolate_outwards_with_nan=True leaves gaps); floats are interpolated, integers keep the value before. The same
# revolution counter stored as uint16 is up to one count behind.
# Output seen:
#   time    [0.0, 0.5, 1.0, 2.0, 3.0]
#   float   [0.0, 5.0, 10.0, 10.0, 10.0]
#   integer [0, 0, 10, 10, 10]
set -euo pipefail
folder=$(mktemp -d); trap 'rm -rf "$folder"' EXIT; cd "$folder"
python3 -m venv venv && venv/bin/pip install -q asammdf==8.8.28 numpy==2.4.6 pandas==3.1.1
venv/bin/python - <<'PY'
import sys

import numpy as np
from asammdf import MDF, Signal

short, long = np.array([0.0, 1.0]), np.array([0.0, 0.5, 1.0, 2.0, 3.0])
record = MDF(version="4.10")
record.append([Signal(np.array([0.0, 10.0]), short, name="float"), Signal(np.array([0, 10], "u2"), short, name="integer")])
record.append(Signal(np.ones(5), long, name="other"))
table = record.to_dataframe()
print("time   ", table.index.tolist())
print("float  ", table["float"].tolist())
print("integer", table["integer"].tolist())
sys.exit(0 if table["float"].tolist() == [0, 5, 10, 10, 10] and table["integer"].tolist() == [0, 0, 10, 10, 10] else 1)
PY
