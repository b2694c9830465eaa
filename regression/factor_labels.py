"""Labels of a study's factors: symbols, units and words."""

import re
from dataclasses import dataclass

from crankbase.drawing.diagram_style import math_symbol
from crankbase.model import field_extra
from crankbase.units.units import DISPLAY_UNITS
from regression.throw_values import declaration

PAPER_SYMBOL = re.compile(r"[A-Za-z](_[a-z]+)?")


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


def factor_text(name: str) -> str:
    """Write "web width B" for a diagram, in math notation if the factor has a symbol."""
    symbol = factor_label(name).symbol
    words = name.replace("_", " ")
    return words if symbol == name else f"{words} {math_symbol(symbol)}"


def term_text(name: str) -> str:
    """Write the papers' symbols in a term such as "ln(L_shm)^2 h" in math notation, free names in words."""

    def word(found: re.Match[str]) -> str:
        text = found[0]
        return math_symbol(text) if PAPER_SYMBOL.fullmatch(text) else text.replace("_", " ")

    return re.sub(r"[A-Za-z][\w.]*", word, name)
