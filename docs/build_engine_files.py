"""Write docs/engine-files.md from the declarations of the fields.

Run by hand after a change of a field: ``python docs/build_engine_files.py``; a test compares.
"""

from pathlib import Path
from typing import Literal, get_args, get_origin

from pydantic_core import PydanticUndefined

from crankfem import engine_sections
from fem.material import Material
from geometry.model import InputModel, field_extra, part_kind
from geometry.quantity import DISPLAY_UNITS, show_quantity
from geometry.shaft_ends import ShaftEnds
from geometry.throw import CrankThrow

SECTIONS: tuple[tuple[type[InputModel], str], ...] = (
    (engine_sections.Engine, "required"),
    (CrankThrow, "required"),
    (engine_sections.ShaftLayout, "optional"),
    (ShaftEnds, "optional"),
    (Material, "optional, steel by default"),
    (engine_sections.Rod, "required"),
    (engine_sections.Piston, "required"),
    (engine_sections.Flywheel, "required"),
    (engine_sections.FreeEnd, "optional"),
    (engine_sections.ThrustBearing, "required"),
    (engine_sections.Gas, "optional; without it reactions are given for 100 kN"),
    (engine_sections.VibrationSettings, "optional"),
    (engine_sections.TorqueTable, "optional"),
    (engine_sections.TwoMassInput, "optional"),
)

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

Files of a study need only `[throw]` and `[study]`. `crankfem new MY.toml --from 6chn25-34` copies a
complete file to start from.
"""

STUDY = """
## [study] (optional)

| field | unit | allowed | meaning |
|---|---|---|---|
| held_out | | 1 to 1000, default 8 | further designs that judge the fits, a Latin hypercube over the box |
| seed | | whole number, default 1 | of the Latin hypercube |
| accuracy | | 0.001 to 0.1, default 0.01 | relative accuracy of each design's axial compliance |

`[study.factors]` lists levels for any fields of `[throw]`; all combinations are run and fitted:

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
    for model, need in SECTIONS:
        parts += _section(model, f"[{model.section}]", need)
    return "\n".join(parts) + "\n" + STUDY


def _section(model: type[InputModel], title: str, need: str) -> list[str]:
    """Describe a section and the tables in it."""
    parts = [
        f"\n## {title} ({need})\n",
        "| field | unit | allowed | meaning |\n|---|---|---|---|",
    ]
    tables: list[str] = []
    described: set[type[InputModel]] = set()
    for name, info in model.model_fields.items():
        kind = part_kind(info)
        if kind is None:
            unit = field_extra(info, "unit")
            shown = "" if unit is None else DISPLAY_UNITS.get(unit, (unit, 1.0))[0]
            symbol = field_extra(info, "symbol")
            meaning = (info.description or "") + (f" ({symbol})" if symbol else "")
            parts.append(f"| {name} | {shown} | {_allowed(info)} | {meaning} |")
            continue
        inner = f"{title[1:-1]}.{name}"
        inner = f"[[{inner}]]" if field_extra(info, "many") else f"[{inner}]"
        parts.append(f"| {name} | | a table {inner} | {info.description} |")
        if kind not in described:
            tables += _section(kind, inner, "optional")
            described.add(kind)
    return parts + tables


def _allowed(info: object) -> str:
    unit, low, high = (field_extra(info, key) for key in ("unit", "minimum_si", "maximum_si"))
    allowed = ""
    if unit is not None and low is not None and high is not None:
        allowed = f"{show_quantity(low, unit)} to {show_quantity(high, unit)}"
    if get_origin(info.annotation) is Literal:
        allowed = " or ".join(get_args(info.annotation))
    default = info.default
    if default is not PydanticUndefined and default is not ... and default is not None:
        text = show_quantity(default, unit) if unit and isinstance(default, float) else f"{default}"
        allowed += f"{', ' if allowed else ''}default {text}"
    return allowed


if __name__ == "__main__":
    (Path(__file__).parent / "engine-files.md").write_text(page(), encoding="utf-8")
