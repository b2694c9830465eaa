"""Write docs/engine-files.md from the declarations of the fields.

Run by hand after a change of a field: ``python docs/build_engine_files.py``; a test compares.
"""

from pathlib import Path

from crankfem.files.engine.field_tables import section_tables

INTRODUCTION = """# Engine files

An engine file is TOML. A quantity is text with its unit; what stands in the table is one of many units
that are understood ("254 mm", "0.254 m" and "10 in" are the same). A speed of "500 1/min" means
revolutions. A value can stand alone or in a table with its source:

```toml
crank_radius = "170 mm"
pin_diameter = { value = "180 mm", source = "drawing 12.3" }
fillet_radius = { value = "12 mm", assumed = "usual for this size" }
```

`assumed` marks values that nobody gave; the report lists them. Short names of sources are explained in
the section `[sources]`: `name = "full citation"`. Unknown sections and fields are refused.

What a file describes follows from its sections:

| sections | it serves |
|---|---|
| `[throw]`, or several `[throws.NAME]` | `throw`, `stress`, `formulas`, `draw`, `export` |
| and `[engine]`, `[rod]`, `[piston]`, usually `[gas]` | also `mechanism`, `harmonics` |
| and `[flywheel]`, `[thrust_bearing]` | also `run`, `vibration` |

V engines say `bank_angles`, cylinder by cylinder, counted as `crank_angles` are. Here a V6 of 90 deg on three
throws whose pins are split by 30 deg, so that it fires evenly (`data/engines/buick-3800.toml`):

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

Shafts whose throws are unequal, in counterweights or lengths, have several throws by name in place of
`[throw]`, and say for each crank which one it is:

```toml
[throws.plain]
crank_radius = "64 mm"
# ... all of a throw

[throws.heavy]
like = "plain"                       # and what differs:
[throws.heavy.counterweight]
outer_radius = "95 mm"
angle = "120 deg"

[shaft]
throws = ["heavy", "plain", "plain", "heavy"]
```

Each distinct throw is analyzed once; chains, balance, bearings and the whole crankshaft take each crank's
own. [throws.md](throws.md#unequal-throws-in-a-shaft) shows such a shaft.

Rods hinged to other rods are in the section `[hinged_rods]` (`data/engines/8chn26-26.toml`). Which way the
shaft turns follows from the firing order.

Files of a study need only `[throw]` and `[study]` (of several throws `throw = "NAME"` in `[study]` says
which one varies; it is the one at the free end by default). `crankfem new MY.toml --from 6chn25-34` copies a
complete file to start from; `crankfem fields throw` prints a section of this page. What the dimensions of
a throw mean is shown in [throws.md](throws.md).

## Changed in Python

A file is read once; what is tried with it stands in Python:

```python
import crankfem as cf

engine = cf.load_engine("6chn25-34")
stiffer = engine.changed(throw={"web_thickness": 0.075}, flywheel={"inertia": 300.0})  # m, kg m^2
damper = {"kind": "viscous", "ring_inertia": 6.0, "damping": 3000.0}
damped = engine.changed(torsional_damper=damper)
throw = engine.throw.changed(pin_fillet_radius=0.010)
```

Each section takes its changed fields in SI units, a whole section, or None to be left out (throws by name
are changed so: `throws={"heavy": {"web_thickness": 0.03}}`); everything is
checked as a file is, and `cf.engine_vibration(damped)` calculates the engine as changed. The records of a
file (throws, webs, materials, sections) have the same method. `cf.engines.mechanism_of(engine)` is the
mechanism of an engine as it is, for `cf.run_mechanism`.
"""

STUDY = """
`[study.factors]` says what varies, `[study.relations]` what follows from it; [studies.md](studies.md)
explains all of it, the designs and their own fields (`resolution`, `generators`, `face`, `file`):

```toml
[study.factors]
web_width = ["270 mm", "300 mm", "330 mm"]
web_thickness = ["38 mm", "68 mm", "98 mm"]
pin_length = ["120 mm", "139 mm", "158 mm"]
```
"""


def page() -> str:
    """Return the text of the page."""
    parts = [INTRODUCTION]
    for table in section_tables():
        parts.append(f"\n## {table.title} ({table.need})\n")
        parts.append("| field | unit | allowed | meaning |\n|---|---|---|---|")
        parts += [
            f"| {row.name} | {row.unit} | {row.allowed} | {row.meaning} |" for row in table.rows
        ]
    return "\n".join(parts) + "\n" + STUDY


if __name__ == "__main__":
    (Path(__file__).parent / "engine-files.md").write_text(page(), encoding="utf-8")
