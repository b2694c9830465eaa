#!/usr/bin/env bash
# Universal file, type 58, written by pyuff 2.5.8: its times have six digits, even where its values have double precision.
# Expected: "double precision", or a binary set, keeps times as exactly as values.
# What happens: start and step of an even abscissa are fields of 13 characters (E13.5) in the header of text and binary
# alike; an uneven abscissa in text is of 13 characters beside values of 20. (Uneven and binary is exact.)
# Output seen:
#   even and binary, 10 s at 51.2 kHz: last instant late by 1.311 samples
#   even and binary, start 1234.56789 s: read 1234.57000 s
#   uneven and text, 100 pulses at 3 kHz after 100 s: 34 different instants
set -euo pipefail
folder=$(mktemp -d); trap 'rm -rf "$folder"' EXIT; cd "$folder"
python3 -m venv venv && venv/bin/pip install -q pyuff==2.5.8
venv/bin/python - <<'PY'
import os
import sys

import numpy as np
import pyuff


def read_back(times, even, binary):
    record = {"type": 58, "binary": binary, "func_type": 1, "rsp_node": 1, "rsp_dir": 1, "ref_node": 1, "ref_dir": 1}
    record |= {"orddenom_spec_data_type": 0, "x": times, "data": 0 * times, "abscissa_spacing": even}
    pyuff.UFF("record.uff").write_sets(record)
    instants = np.atleast_1d(pyuff.UFF("record.uff").read_sets())[0]["x"]
    os.remove("record.uff")
    return instants


times = np.arange(512000) / 51200
late = (read_back(times, 1, 1)[-1] - times[-1]) * 51200
start = read_back(1234.56789 + np.arange(4) / 51200, 1, 1)[0]
pulses = len(np.unique(read_back(100 + np.arange(100) / 3000, 0, 0)))
print(f"even and binary, 10 s at 51.2 kHz: last instant late by {late:.3f} samples")
print(f"even and binary, start 1234.56789 s: read {start:.5f} s")
print(f"uneven and text, 100 pulses at 3 kHz after 100 s: {pulses} different instants")
sys.exit(0 if late > 0.1 and start == 1234.57 and pulses < 50 else "changed")
PY
