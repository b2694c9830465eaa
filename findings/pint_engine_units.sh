#!/usr/bin/env bash
# pint 0.25.3: units as engine data sheets write them are accepted as other units.
# Expected: "Nm" is torque, "PS" horsepower, "bar(g)" gauge pressure, "U/min" revolutions per minute, "kt" kilotonnes and
# "MT" megatonnes, "ton" 1000 kg and "mhp" the metric horsepower, or each is refused as unknown.
# What happens: they parse as number metric of yarn, petasiemens, bar times gram, enzyme units per minute, knot, megatesla,
# short ton and a thousandth of the mechanical horsepower. None of it fails before a conversion, and where only magnitudes
# are taken, never.
# Output seen:
#   Nm -> number_meter, PS -> petasiemens, bar(g) -> bar * gram, U/min -> enzyme_unit / minute, kt -> knot,
#   MT -> megatesla, ton -> ton, mhp -> millihorsepower
#   ton is 907.2 kilogram
set -euo pipefail
folder=$(mktemp -d); trap 'rm -rf "$folder"' EXIT; cd "$folder"
python3 -m venv venv && venv/bin/pip install -q pint==0.25.3
venv/bin/python - <<'PY'
import sys

import pint

units = pint.UnitRegistry()
names = {text: str(units(text).units) for text in ("Nm", "PS", "bar(g)", "U/min", "kt", "MT", "ton", "mhp")}
print(", ".join(f"{text} -> {name}" for text, name in names.items()))
print(f"ton is {units('ton').to('kg'):.1f}")
wrong = ["number_meter", "petasiemens", "bar * gram", "enzyme_unit / minute", "knot", "megatesla", "ton", "millihorsepower"]
sys.exit(0 if list(names.values()) == wrong and units("ton").to("kg").magnitude < 910 else "changed")
PY
