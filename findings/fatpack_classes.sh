#!/usr/bin/env bash
# fatpack 0.7.8: find_rainflow_ranges counts on 64 classes unless told otherwise, so no range is the one of the record.
# Expected: the ranges of the record, and every closed cycle of it, as the name and a returned array of floats suggest.
# What happens: reversals are moved to the middle of 1/64 of the whole range first (k=64): a ripple below that is lost at
# some levels and becomes a whole class at others, so that its damage is wrong both ways. k has to be raised by hand.
# A ripple of range 1.4, 500 times, on one slow swing of range 200 (class 3.15):
# Output seen:
#   k=64: 174 cycles of range 3.15 to 3.15; k=100000: 499 cycles of range 0.83 to 1.40
set -euo pipefail
folder=$(mktemp -d); trap 'rm -rf "$folder"' EXIT; cd "$folder"
python3 -m venv venv && venv/bin/pip install -q fatpack==0.7.8 numpy==2.4.6
venv/bin/python - <<'PY'
import sys

import fatpack
import numpy as np

time = np.linspace(0, 100, 100001)
record = 100 * np.sin(2 * np.pi * 0.01 * time) + 0.7 * np.sin(2 * np.pi * 5 * time)
coarse, fine = (np.sort(fatpack.find_rainflow_ranges(record, **classes))[:-1] for classes in ({}, {"k": 100000}))
coarse, fine = coarse[coarse < 10], fine[fine < 10]
print(f"k=64: {len(coarse)} cycles of range {coarse.min():.2f} to {coarse.max():.2f};", end=" ")
print(f"k=100000: {len(fine)} cycles of range {fine.min():.2f} to {fine.max():.2f}")
sys.exit(0 if len(coarse) < 300 < len(fine) and coarse.min() > 2 > fine.max() else "changed")
PY
