"""Write docs/engine-files.md from the declarations of the fields.

Run by hand after a change of a field: ``python docs/build_engine_files.py``; a test compares.
"""

from pathlib import Path

from crankfem.files.engine.field_tables import section_tables

INTRODUCTION = """# Engine files

An engine file is TOML. `crankfem fields throw` prints the fields of a section with unit, allowed range,
default and meaning; `crankfem new mine.toml` writes a commented file. A quantity is text with any unit of its
kind ("254 mm" and "10 in" are the same; "500 1/min" means revolutions), alone or in a table with its source:

```toml
crank_radius = "170 mm"
pin_diameter = { value = "180 mm", source = "drawing 12.3" }
fillet_radius = { value = "12 mm", assumed = "usual for this size" }
```

An inertia may be given as GD2: `flywheel_effect = "1800 kg m^2"` (or kgf m2) for an `inertia` of 450. The
report lists `assumed` values. `[sources]` explains short names of sources: `name = "full citation"`. Unknown
sections and fields are refused.

| sections | serve |
|---|---|
| `[throw]`, or several `[throws.NAME]` | `throw`, `stress`, `formulas`, `draw`, `export` |
| and `[engine]`, `[rod]`, `[piston]`, usually `[gas]` | also `mechanism`, `harmonics` |
| and `[flywheel]`, `[thrust_bearing]` | also `run`, `vibration` |
| `[throw]` and `[study]` | `doe`, `fit` (`throw = "NAME"` selects one; default: at the free end) |

V engines give `bank_angles`, counted as `crank_angles` are. Here a V6 of 90 deg with pins split by 30 deg
(`data/engines/buick-3800.toml`):

```toml
[engine]
cylinders = 6
crank_angles = ["0 deg", "30 deg", "240 deg", "270 deg", "120 deg", "150 deg"]
bank_angles = ["45 deg", "-45 deg", "45 deg", "-45 deg", "45 deg", "-45 deg"]
throws = [1, 1, 2, 2, 3, 3]          # which throw each cylinder works on
firing_order = [1, 6, 5, 4, 3, 2]
# ... bore, stroke, speeds

[[throw.further_pins]]
angle = "30 deg"
web_thickness = "0 mm"               # the halves of the pin touch

[shaft]
throw_angles = ["0 deg", "240 deg", "120 deg"]
```

`[hinged_rods]` describes rods hinged to other rods (`data/engines/8chn26-26.toml`). The firing order gives
the sense of rotation. [Unequal throws](throws.md#unequal-throws-in-a-shaft) have names.

## Tables

A table of pressure, torque or gas force over the angle is text with commas, semicolons, tabs or spaces
between cells, decimal points or commas, in UTF-8, UTF-16 or Windows-1252, or a spreadsheet (.xlsx;
`pip install 'crankfem[spreadsheets]'`). The header names quantity and unit, as
`crank_angle_deg;gauge_pressure_bar`; of any other table a `reading` says what its columns hold:

```toml
[gas]
pressure_table = "bench.csv"
reading = { columns = { crank_angle_deg = "CA", absolute_pressure_bar = 3 }, top = "360 deg" }
```

by heading or number from 1; `top` is the firing top in the table. Several cycles give their mean; `check`
tells their scatter. Uneven samples are resampled, a closing row may differ by noise. Faults are told all at
once.

## Changed in Python

```python
import crankfem as cf

engine = cf.load_engine("6chn25-34")
stiffer = engine.changed(throw={"web_thickness": 0.075}, flywheel={"inertia": 300.0})  # m, kg m^2
damper = {"kind": "viscous", "ring_inertia": 6.0, "damping": 3000.0}
damped = engine.changed(torsional_damper=damper)
throw = engine.throw.changed(pin_fillet_radius=0.010)
damped.save("damped.toml")  # with sources; replaces no file that it has not written
```

Each section takes its changed fields in SI units, a whole section, or None to be left out; named throws as
`throws={"heavy": {"web_thickness": 0.03}}`. Changes are checked as a file is. `cf.engine_vibration(damped)`
and `cf.run_mechanism(damped)` calculate it.

## All sections

Optional, unless it says otherwise.
"""

STUDY = """
`[study.factors]` gives what varies, `[study.relations]` what follows from it ([studies.md](studies.md);
designs have their own fields `resolution`, `generators`, `face`, `file`):

```toml
[study.factors]
web_width = ["270 mm", "300 mm", "330 mm"]
web_thickness = ["38 mm", "68 mm", "98 mm"]
pin_length = ["120 mm", "139 mm", "158 mm"]
```
"""


def page() -> str:
    """Return the text of the page."""
    lines = [INTRODUCTION, "| section | fields |\n|---|---|"]
    first: dict[tuple[str, ...], str] = {}
    for table in section_tables():
        names = tuple(row.name for row in table.rows)
        fields = first.get(names) or ", ".join(names)
        first.setdefault(names, f"those of `{table.title}`")
        need = "" if table.need == "optional" else f" ({table.need.removeprefix('optional, ')})"
        lines.append(f"| `{table.title}`{need} | {fields} |")
    return "\n".join(lines) + "\n" + STUDY


if __name__ == "__main__":
    (Path(__file__).parent / "engine-files.md").write_text(page(), encoding="utf-8")
