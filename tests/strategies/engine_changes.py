"""Shipped engines with a single field changed: values within and near its range, other words, none."""

import tomllib
from pathlib import Path
from typing import Any, get_args

from hypothesis import strategies as st

from crankbase.model import InputModel, field_extra, limits_of, part_kind
from crankfem.files.engine.file_kinds import SECTIONS
from regression.formulas.axial_formulas import AXIAL_FORMULA_NAMES
from regression.formulas.torsional_formulas import TORSIONAL_FORMULA_NAMES

ENGINES = Path(__file__).resolve().parents[2] / "data" / "engines"
WHOLE = tuple(
    sorted(path for path in ENGINES.glob("*.toml") if "\n[flywheel]" in path.read_text("utf-8"))
)
# Optional sections, given to an engine that has none of them.
ADDED: dict[str, dict[str, Any]] = {
    "limits": {"tensile_strength": "600 MPa", "yield_strength": "350 MPa"},
    "damping": {"torsional_magnifier": 40.0},
    "ranges": {"axial_compliance": [0.95, 1.1]},
    "vibration": {"reciprocating": "mean"},
    "misfire": {"missing_share": 0.5},
    "load": {"law": "propeller"},
    "bearings": {"stiffness": "2e9 N/m"},
    "driven": {"inertia": "20 kg m^2", "coupling_stiffness": "1e5 N m/rad"},
    "axial_damper": {"damping": "1e5 N s/m"},
    "torsional_damper": {"kind": "viscous", "ring_inertia": "2 kg m^2", "damping": "100 N m s/rad"},
    "propeller_forces": {
        "node": "flywheel",
        "blades": 4,
        "rated_speed": "200 1/min",
        "rated_thrust": "100 kN",
        "rated_torque": "50 kN m",
        "torque_shares": [0.1],
    },
    "strength": {
        "tensile_strength": "800 MPa",
        "manufacture": "continuous grain flow",
        "piston": "trunk",
    },
}
WORDS = {
    "axial_source": ("fe", "law", *AXIAL_FORMULA_NAMES),
    "torsional_source": ("fe", "law", *TORSIONAL_FORMULA_NAMES),
    "node": ("flywheel", "free end", "propeller"),
    "crankshaft_rule": ("KR main engine", "KR generator set"),
    "drives": ("propeller", "generator"),
}
OTHERS = ("sources", "study", "shaft_line", "two_mass_check", "torque")


def _spelled(value: Any) -> str:
    """Write a value as TOML does."""
    if isinstance(value, dict):
        return "{ " + ", ".join(f"{name} = {_spelled(one)}" for name, one in value.items()) + " }"
    if isinstance(value, list):
        return "[" + ", ".join(map(_spelled, value)) + "]"
    if isinstance(value, bool):
        return str(value).lower()
    return repr(value) if isinstance(value, int | float) else f'"{value}"'.replace("\\", "\\\\")


def toml_text(sections: dict[str, dict[str, Any]]) -> str:
    """Write sections as TOML."""
    return "".join(
        f"[{name}]\n" + "".join(f"{key} = {_spelled(value)}\n" for key, value in values.items())
        for name, values in sections.items()
    )


def _number(draw: st.DrawFn, limits: tuple[float | None, float | None], given: Any) -> float:
    """Draw a number: near the one given, at an end of the range, or anywhere in it."""
    low, high = limits
    first = 0.0 if low is None else low
    last = 1e3 if high is None else high
    if given and draw(st.booleans()):
        return float(given * draw(st.floats(0.5, 2.0)))
    if draw(st.integers(0, 3)) == 0:
        return float(draw(st.sampled_from([first, last])))
    share = draw(st.floats(0.0, 1.0))
    if first > 0.0:
        return float(first * (last / first) ** share)
    return float(first + (last - first) * share)


@st.composite
def changed_engines(draw: st.DrawFn, engines: tuple[Path, ...] = WHOLE) -> str:
    """Draw the text of an engine file with one field changed, and perhaps one section more."""
    sections = tomllib.loads(draw(st.sampled_from(engines)).read_text("utf-8"))
    sections.pop("study", None)
    more = draw(st.sampled_from([None, *ADDED]))
    if more is not None:
        sections.setdefault(more, dict(ADDED[more]))
    names = [one for one in sections if one in SECTIONS and one not in OTHERS]
    section = more or draw(st.sampled_from(names))
    model: type[InputModel] = SECTIONS[section].model
    values = sections[section]
    fields = [name for name, info in model.model_fields.items() if part_kind(info) is None]
    field = draw(st.sampled_from(fields))
    info = model.model_fields[field]
    if field in values and draw(st.integers(0, 9)) == 0:
        del values[field]
        return toml_text(sections)
    unit, kinds = field_extra(info, "unit"), get_args(info.annotation)
    words = WORDS.get(field, tuple(one for one in kinds if isinstance(one, str)))
    if words:
        values[field] = draw(st.sampled_from(words))
    elif info.annotation is bool:
        values[field] = draw(st.booleans())
    elif unit is not None and "tuple" not in str(info.annotation):
        before = getattr(_read(model, values), field, None)
        number = _number(draw, limits_of(info), before if isinstance(before, int | float) else 0)
        whole = "int" in str(info.annotation)
        values[field] = f"{number!r} {unit}" if unit else round(number) if whole else number
    return toml_text(sections)


def _read(model: type[InputModel], values: dict[str, Any]) -> InputModel | None:
    plain = {
        name: one["value"] if isinstance(one, dict) and "value" in one else one
        for name, one in values.items()
    }
    try:
        return model.from_text(plain)
    except ValueError:
        return None
