#!/usr/bin/env bash
# ROSS 2.3.0 changes what hertz means for every quantity of pint 0.25.3 in the process.
# Expected: import ross leaves the conversions of other code as they were.
# What happens: ROSS loads "Hz = rps" into a registry of its own and makes it the application registry, so that
# pint.Quantity(1500, "rpm").to("Hz") is 25 after the import and 157 before; a hertz is then 2 pi rad/s.
# Output seen:
#   before 157.08 Hz, after 25.00 Hz
set -euo pipefail
folder=$(mktemp -d); trap 'rm -rf "$folder"' EXIT; cd "$folder"
python3 -m venv venv && venv/bin/pip install -q ross-rotordynamics==2.3.0 plotly==5.24.1 pint==0.25.3
venv/bin/python - <<'PY'
import subprocess
import sys

line = "import pint; print('%.2f' % pint.Quantity(1500, 'rpm').to('Hz').magnitude)"
before, after = (
    subprocess.run([sys.executable, "-c", text], capture_output=True, text=True, check=True).stdout.split()[-1]
    for text in (line, "import ross; " + line)
)
print(f"before {before} Hz, after {after} Hz")
sys.exit(0 if (before, after) == ("157.08", "25.00") else "changed")
PY
