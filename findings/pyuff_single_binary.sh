#!/usr/bin/env bash
# pyuff 2.5.8: write_sets(..., force_double=False) of a binary function (type 58) writes numbers of twice the size that its
# header says.
# Expected: 4 bytes for each number, as ord_data_type 2 (single precision) and the number of bytes in the header say; 7
# numbers are read back as 7. In text they are.
# What happens: the numbers have 8 bytes each ("always write data in double precision") below a header of single precision.
# They are read back in halves, without a word: twice as many values, all wrong, and num_pts is still 7.
# Output seen:
#   text:   7 values of 7: [1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0]
#   binary: 14 values of 7: [0.0, 1.875, 0.0, 2.0, 0.0, 2.125, 0.0]
set -euo pipefail
folder=$(mktemp -d); trap 'rm -rf "$folder"' EXIT; cd "$folder"
python3 -m venv venv && venv/bin/pip install -q pyuff==2.5.8
venv/bin/python - <<'PY'
import sys

import numpy as np
import pyuff

record = {"type": 58, "func_type": 1, "rsp_node": 1, "rsp_dir": 1, "ref_node": 1, "ref_dir": 1, "ord_data_type": 2}
record |= {"orddenom_spec_data_type": 0, "x": np.arange(7.0), "data": np.arange(1.0, 8.0), "abscissa_spacing": 1}
values = {}
for name, binary in (("text", 0), ("binary", 1)):
    pyuff.UFF(name + ".uff").write_sets(record | {"binary": binary}, force_double=False)
    read = pyuff.UFF(name + ".uff").read_sets()
    values[name] = read["data"].tolist()
    print(f"{name + ':':<7} {len(values[name])} values of {read['num_pts']}: {values[name][:7]}")
sys.exit(0 if len(values["text"]) == 7 and len(values["binary"]) == 14 and values["binary"][1] == 1.875 else "changed")
PY
