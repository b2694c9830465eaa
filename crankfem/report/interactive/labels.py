"""Symbols, units and a design's dimensions as plotly writes them."""

import re

import numpy as np
from numpy.typing import NDArray

from crankbase.units.units import DISPLAY_UNITS
from crankfem.report.interactive.style import literal
from regression.factor_labels import factor_label
from regression.plans.factors import Factor

Array = NDArray[np.float64]


def symbol_text(symbol: str) -> str:
    """Write a symbol such as L_shm with its index set low.

    Examples
    --------
    >>> symbol_text("L_shm")
    'L<sub>shm</sub>'
    """
    return re.sub(r"^([A-Za-z]+)_(\w+)$", r"\1<sub>\2</sub>", symbol)


def display_unit(unit: str) -> tuple[str, float]:
    """Return the unit in which a quantity of an SI unit is shown, and its size in SI."""
    text, size = DISPLAY_UNITS.get(unit, (unit, 1.0))
    return text.replace("1e-9", "10<sup>-9</sup>") or "1", size


def with_unit(number: str, unit: str) -> str:
    """Write a number, or what stands for one, before a unit that may begin with a power of ten."""
    return f"{number}·{unit}" if unit.startswith("10<") else f"{number} {unit}"


def factor_text(factor: Factor) -> str:
    """Write "web width B"."""
    symbol = factor_label(factor.name).symbol
    words = literal(factor.name.replace("_", " "))
    return words if symbol == factor.name else f"{words} {symbol_text(symbol)}"


def factor_title(factor: Factor) -> str:
    """Write "web width B [mm]"."""
    if factor.labels:
        return factor_text(factor)
    return f"{factor_text(factor)} [{display_unit(factor.unit)[0]}]"


def choice_labels(factor: Factor) -> list[str]:
    """Return the labels of a choice, none of a number."""
    return [literal(label) for label in factor.labels]


def display_values(factor: Factor, values: Array) -> Array:
    """Return a factor's values in the unit in which they are shown; of a choice the labels' numbers."""
    return values if factor.labels else values / display_unit(factor.unit)[1]


def design_texts(factors: tuple[Factor, ...], values: Array) -> list[str]:
    """Return a text for each design (n, k) that says its dimensions, one a line."""
    columns = []
    for place, factor in enumerate(factors):
        shown = display_values(factor, values[:, place])
        unit = display_unit(factor.unit)[0] if factor.unit else ""
        name, labels = literal(factor.name.replace("_", " ")), choice_labels(factor)
        columns.append(
            [
                f"{name} " + (labels[round(value)] if labels else f"{value:.5g} {unit}".strip())
                for value in shown.tolist()
            ]
        )
    return ["<br>".join(lines) for lines in zip(*columns, strict=True)]
