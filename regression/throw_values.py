"""The dimensions of a throw by name, also those of its parts: "counterweight.thickness"."""

from dataclasses import dataclass

from pydantic.fields import FieldInfo

from crankbase.errors import InputError
from crankbase.model import InputModel, field_extra, part_kind
from crankbase.quantity import DISPLAY_UNITS
from crankbase.sentences import amount
from geometry.throw import CrankThrow
from geometry.throw_dimensions import values_by_path

# What a dimension is where it is not given: a share of another one.
DEFAULTS = {
    "main_journal_fillet_radius": ("fillet_radius", 1.0),
    "pin_fillet_radius": ("fillet_radius", 1.0),
    "web_journal_end": ("web_width", 0.5),
    "web_pin_end": ("web_width", 0.5),
    "web_tip_thickness": ("web_thickness", 1.0),
    "web_foot_thickness": ("web_thickness", 1.0),
}
# Two numbers are one dimension if they differ by less than this share: "98 mm" read from text and
# 0.098 may differ in the last digit.
SAME = 1e-9
# Of the range in which a field is declared.
ENDS = ("minimum", "maximum")


def declaration(name: str) -> FieldInfo | None:
    """Return the declaration of a throw's field, or of one of its parts' fields; else None."""
    kind: type[InputModel] = CrankThrow
    *parts, last = name.split(".")
    for part in parts:
        if part.isdigit():
            continue
        info = kind.model_fields.get(part)
        inner = None if info is None else part_kind(info)
        if inner is None:
            return None
        kind = inner
    return kind.model_fields.get(last)


def field_unit(name: str) -> str | None:
    """Return the SI unit of a throw's field; None if there is no such field or it is no quantity.

    Examples
    --------
    >>> field_unit("web_width"), field_unit("counterweight.angle"), field_unit("width_ratio")
    ('m', 'rad', None)
    """
    info = declaration(name)
    unit = None if info is None else field_extra(info, "unit")
    return None if unit is None else str(unit)


def check_dimension(field: str, name: str, value: float) -> None:
    """Refuse a number that a throw's field, or one of its parts', cannot have.

    Others may be any (`InputError`).
    """
    info = declaration(name)
    low, high = (None if info is None else field_extra(info, f"{end}_si") for end in ENDS)
    if (low is None or low <= value) and (high is None or value <= high):
        return
    bounds = [f"{format_value(name, low)} or more"] if low is not None else []
    bounds += [f"{format_value(name, high)} or less"] if high is not None else []
    raise InputError(
        f"{field}: given {format_value(name, value)}; allowed is {' and '.join(bounds)}, as for every throw."
    )


def format_value(name: str, value: float, unit: str | None = None) -> str:
    """Write a value into a text in its usual unit: that of its field, or the one given."""
    known = field_unit(name) if unit is None else unit
    return f"{value:g}" if not known else amount(value, known)


def throw_values(throw: CrankThrow, *, spelled_out: bool = False) -> dict[str, float | str]:
    """All values that describe a throw, dimensions [SI] and labels by name.

    Absent and default ones are left out.

    `spelled_out` keeps a dimension that is given with the value that it would have anyway, such as a
    pin's fillet equal to all fillets: this throw is the same without it, but it does not follow when
    the other one changes.

    Examples
    --------
    >>> throw = CrankThrow(
    ...     crank_radius=0.170, main_journal_diameter=0.220, pin_diameter=0.180,
    ...     main_journal_length=0.120, pin_length=0.139, web_width=0.285, web_thickness=0.068,
    ...     fillet_radius=0.012, pin_fillet_radius=0.012,
    ... )
    >>> list(throw_values(throw))[-3:]
    ['web_thickness', 'fillet_radius', 'web_outline']
    """
    values = dict(values_by_path(throw))
    for name, (other, share) in DEFAULTS.items():
        base = values.get(other)
        value = values.get(name)
        if spelled_out or not isinstance(value, float) or not isinstance(base, float):
            continue
        if same_dimension(value, share * base):
            del values[name]
    for name, info in CrankThrow.model_fields.items():
        if field_extra(info, "feature") and values.get(name) == 0.0:
            del values[name]
    return values


def same_dimension(first: float, second: float) -> bool:
    """Whether two numbers are the same dimension."""
    return abs(first - second) <= SAME * max(abs(first), abs(second))


@dataclass(frozen=True)
class FactorLabel:
    """Label of a factor in a printed equation: its symbol, its unit and that unit's size."""

    symbol: str
    unit: str
    size: float


def factor_label(name: str) -> FactorLabel:
    """Label of a throw's dimension from its declaration; of another factor its plain name.

    Examples
    --------
    >>> factor_label("web_width")
    FactorLabel(symbol='B', unit='mm', size=0.001)
    >>> factor_label("counterweight.thickness")
    FactorLabel(symbol='counterweight.thickness', unit='mm', size=0.001)
    >>> factor_label("web_outline=rectangle")
    FactorLabel(symbol='[web_outline = rectangle]', unit='', size=1.0)
    """
    field, equals, label = name.partition("=")
    if equals:
        return FactorLabel(f"[{field} = {label}]", "", 1.0)
    declared = declaration(name)
    if declared is None:
        return FactorLabel(name, "", 1.0)
    unit = str(field_extra(declared, "unit") or "")
    shown, size = DISPLAY_UNITS.get(unit, (unit, 1.0))
    symbol = str(field_extra(declared, "symbol") or "")
    return FactorLabel(symbol if symbol and "." not in name else name, shown, size)
