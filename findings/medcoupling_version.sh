#!/usr/bin/env bash
# MEDCoupling, package medcoupling 9.15.0: the library calls itself another version.
# Expected: MEDCouplingVersionStr() names the release that is installed, and can decide what a report or a check relies on.
# What happens: it says 9.14.0. A file or a report that names its writer by it names a release that was not used.
# Output seen:
#   package 9.15.0, library 9.14.0
set -euo pipefail
folder=$(mktemp -d); trap 'rm -rf "$folder"' EXIT; cd "$folder"
python3 -m venv venv && venv/bin/pip install -q medcoupling==9.15.0
venv/bin/python - <<'PY'
import importlib.metadata
import sys

import medcoupling

package, library = importlib.metadata.version("medcoupling"), medcoupling.MEDCouplingVersionStr()
print(f"package {package}, library {library}")
sys.exit(0 if package != library else "changed")
PY
