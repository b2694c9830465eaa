#!/usr/bin/env bash
# npTDMS 1.13.0: two channels of one start whose rates divide each other do not share their common instants.
# Expected: every sample at 1 kHz lies on one at 10 kHz, so a table over time has 1001 rows.
# What happens: time_track spaces each channel by numpy.linspace; of 101 common instants 15 differ by round-off, and
# as_dataframe(time_index=True) makes them rows of their own, 10 attoseconds apart, with gaps in one column each. A join
# or a comparison by == misses them in silence.
# Output seen:
#   common instants 86 of 101, rows 1016, largest difference 1.4e-17 s
set -euo pipefail
folder=$(mktemp -d); trap 'rm -rf "$folder"' EXIT; cd "$folder"
python3 -m venv venv && venv/bin/pip install -q npTDMS==1.13.0 numpy==2.4.6 pandas==3.1.1
venv/bin/python - <<'PY'
import io
import sys

import numpy as np
from nptdms import ChannelObject, TdmsFile, TdmsWriter

file = io.BytesIO()
with TdmsWriter(file) as writer:
    for name, count, step in (("fast", 1001, 1e-4), ("slow", 101, 1e-3)):
        properties = {"wf_increment": step, "wf_start_offset": 0.0, "wf_samples": count}
        writer.write_segment([ChannelObject("g", name, np.zeros(count), properties=properties)])
file.seek(0)
record = TdmsFile.read(file)
fast, slow = (record["g"][name].time_track() for name in ("fast", "slow"))
common, rows = len(np.intersect1d(fast, slow)), len(record.as_dataframe(time_index=True))
print(f"common instants {common} of {len(slow)}, rows {rows}, largest difference {np.abs(fast[::10] - slow).max():.1e} s")
sys.exit(0 if common < len(slow) and rows > len(fast) else "changed")
PY
