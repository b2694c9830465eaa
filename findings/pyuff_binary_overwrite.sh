#!/usr/bin/env bash
# pyuff 2.5.8: write_sets(..., mode="overwrite") of a binary function (type 58) leaves a file without the function.
# Expected: the same file as mode="add" into no file, read back equal.
# What happens: after the text of the header the writer opens the file again in mode "wb", and then "wt" for the last line:
# 7 bytes are left, a lone delimiter, and read_sets returns an empty list without a word. Text sets are not touched by it.
# Output seen:
#   add: 954 bytes, read 1 set; overwrite: 7 bytes, read 0 sets
set -euo pipefail
folder=$(mktemp -d); trap 'rm -rf "$folder"' EXIT; cd "$folder"
python3 -m venv venv && venv/bin/pip install -q pyuff==2.5.8
venv/bin/python - <<'PY'
import os
import sys

import numpy as np
import pyuff

record = {"type": 58, "binary": 1, "func_type": 1, "rsp_node": 1, "rsp_dir": 1, "ref_node": 1, "ref_dir": 1}
record |= {"orddenom_spec_data_type": 0, "x": np.arange(4.0), "data": np.ones(4), "abscissa_spacing": 1}
sizes = {}
for mode in ("add", "overwrite"):
    pyuff.UFF(mode + ".uff").write_sets(dict(record), mode=mode)
    sets = pyuff.UFF(mode + ".uff").read_sets()
    sizes[mode] = os.path.getsize(mode + ".uff"), 1 if isinstance(sets, dict) else len(sets)
print("add: {} bytes, read {} set;".format(*sizes["add"]), "overwrite: {} bytes, read {} sets".format(*sizes["overwrite"]))
sys.exit(0 if sizes["add"][1] == 1 and sizes["overwrite"] == (7, 0) else "changed")
PY
