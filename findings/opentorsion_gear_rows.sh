#!/usr/bin/env bash
# openTorsion 0.3.2: behind a gear pair the rows of a response are no longer the nodes, and which row is gone depends on
# which gear is larger.
# Expected: a train of four nodes answers for four nodes, or drops the driven gear, always the same one.
# What happens: the larger gear of each pair loses its row, so all later nodes move up: "node 2" of an excitation is node 3
# if the driving gear is larger as well as if the driven one is, while row 1 is node 2 in one case and node 1 in the other.
# Inertias 1, 20, 30, 4 kg m2 of the nodes 0 to 3, gears at 1 and 2 of radius 100 and 50 mm, then 50 and 100 mm:
# Output seen:
#   driving gear larger: diagonal of M [1, 35, 4]
#   driven gear larger : diagonal of M [1, 27.5, 4]
set -euo pipefail
folder=$(mktemp -d); trap 'rm -rf "$folder"' EXIT; cd "$folder"
python3 -m venv venv && venv/bin/pip install -q opentorsion==0.3.2
venv/bin/python - <<'PY'
import sys

import opentorsion as ot


def inertias(driving, driven):
    gear = ot.Gear(1, 20.0, driving)
    train = [gear, ot.Gear(2, 30.0, driven, parent=gear)]
    shafts = [ot.Shaft(0, 1, k=1e6), ot.Shaft(2, 3, k=1e6)]
    return ot.Assembly(shafts, [ot.Disk(0, 1.0), ot.Disk(3, 4.0)], train).M.diagonal().tolist()


print("driving gear larger: diagonal of M", inertias(100, 50))
print("driven gear larger : diagonal of M", inertias(50, 100))
# 30 + 20 (50 / 100)**2 = 35 is node 2; 20 + 30 (50 / 100)**2 = 27.5 is node 1
sys.exit(0 if inertias(100, 50) == [1, 35, 4] and inertias(50, 100) == [1, 27.5, 4] else "changed")
PY
