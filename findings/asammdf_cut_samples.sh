#!/usr/bin/env bash
# asammdf 8.8.28: MDF.cut adds samples that nobody recorded at both ends of the piece.
# Expected: cutting out 0.5 s to 2.5 s keeps the samples between, as the word says.
# What happens: include_ends=True is the default, and a value is interpolated at each limit: one tooth pulse per second
# gains two pulses half a period from its neighbors, of which a speed is twice as high at each end.
# Output seen:
#   pulses at [0.0, 1.0, 2.0, 3.0], cut at [0.5, 1.0, 2.0, 2.5], include_ends=False [1.0, 2.0]
set -euo pipefail
folder=$(mktemp -d); trap 'rm -rf "$folder"' EXIT; cd "$folder"
python3 -m venv venv && venv/bin/pip install -q asammdf==8.8.28 numpy==2.4.6 pandas==3.1.1
venv/bin/python - <<'PY'
import sys

import numpy as np
from asammdf import MDF, Signal

record = MDF(version="4.10")
record.append(Signal(np.ones(4), np.arange(4.0), name="tooth"))
whole = record.get("tooth").timestamps.tolist()
pieces = [
    record.cut(start=0.5, stop=2.5, include_ends=ends).get("tooth").timestamps.tolist()
    for ends in (True, False)
]
print(f"pulses at {whole}, cut at {pieces[0]}, include_ends=False {pieces[1]}")
default = record.cut(start=0.5, stop=2.5).get("tooth").timestamps.tolist()
sys.exit(0 if default == pieces[0] == [0.5, 1.0, 2.0, 2.5] and pieces[1] == [1.0, 2.0] else "changed")
PY
