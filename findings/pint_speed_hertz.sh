#!/usr/bin/env bash
# pint 0.25.3: 1500 rpm in hertz is 157, not 25.
# Expected: speed over frequency is the order, so 1500 rpm is 25 Hz, and radians per second are no hertz.
# What happens: a turn is 2 pi and a hertz is 1/s, radian counts as 1: rad/s and Hz convert one to one. A speed converted
# with .to("Hz") is 6.28 times too large.
# Output seen:
#   1500 rpm = 157.08 Hz, 1500 rad/s = 1500.00 Hz
set -euo pipefail
folder=$(mktemp -d); trap 'rm -rf "$folder"' EXIT; cd "$folder"
python3 -m venv venv && venv/bin/pip install -q pint==0.25.3
venv/bin/python - <<'PY'
import sys

import pint

units = pint.UnitRegistry()
rpm, radians = (units.Quantity(1500, unit).to("Hz").magnitude for unit in ("rpm", "rad/s"))
print(f"1500 rpm = {rpm:.2f} Hz, 1500 rad/s = {radians:.2f} Hz")
sys.exit(0 if abs(rpm - 157.08) < 0.01 and abs(radians - 1500) < 1e-9 else "changed")
PY
