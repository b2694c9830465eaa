"""Equations over one factor, and the sizes of their terms and factors."""

import re
from collections.abc import Sequence
from itertools import compress
from typing import Any

import numpy as np

from crankbase.array_checks import Array, Flags
from crankbase.diagrams import (
    BLUE,
    ORANGE,
    PALE,
    Dots,
    display_unit,
    draw_rows,
    math_symbol,
    write_title,
)
from crankbase.frames import Axes
from regression.throw_values import factor_label

POINTS = 80
PAPER_SYMBOL = re.compile(r"[A-Za-z](_[a-z]+)?")


def factor_text(name: str) -> str:
    """Write "web width B" for a diagram, in math notation if the factor has a symbol."""
    symbol = factor_label(name).symbol
    words = name.replace("_", " ")
    return words if symbol == name else f"{words} {math_symbol(symbol)}"


def term_text(name: str) -> str:
    """Write the papers' symbols in a term such as "ln(L_shm)^2 h" in math notation, free names in words."""

    def word(matched: re.Match[str]) -> str:
        text = matched[0]
        return math_symbol(text) if PAPER_SYMBOL.fullmatch(text) else text.replace("_", " ")

    return re.sub(r"[A-Za-z][\w.]*", word, name)


def factor_size(unit: str, labels: Sequence[str]) -> float:
    """Size of the unit that a factor is shown in; of a choice 1."""
    return 1.0 if labels else display_unit(unit)[1]


def label_factor_axis(axes: Axes, name: str, unit: str, labels: Sequence[str]) -> None:
    """Label the horizontal axis with a factor and its unit; for a choice with its labels."""
    if labels:
        axes.set_xticks(range(len(labels)), list(labels), fontsize=8)
        axes.set_xlim(-0.5, len(labels) - 0.5)
    axes.set_xlabel(factor_label_text(name, unit, labels))


def factor_label_text(name: str, unit: str, labels: Sequence[str]) -> str:
    """Write a factor with the unit that it is shown in; a choice has none."""
    shown = display_unit(unit)[0] if unit and not labels else ""
    return f"{factor_text(name)} [{shown}]" if shown else factor_text(name)


def response_text(symbol: str, unit: str) -> str:
    """Write a response with the unit that it is shown in."""
    return f"{math_symbol(symbol)} [{display_unit(unit)[0]}]"


Mask = Flags

KINDS = ((False, BLUE, "o", "fitted runs"), (True, ORANGE, "D", "held out"))


def design_dots(
    x: Array, y: Array, held_out: Mask, hover: str = "", texts: Sequence[str] = ()
) -> list[Dots]:
    """Describe a dot for each design, in the units of the axes, those held out apart."""
    return [
        Dots(
            x[held_out == held],
            y[held_out == held],
            name,
            color,
            symbol,
            hover=f"<b>{name}</b><br>%{{text}}<br>{hover}",
            texts=tuple(compress(texts, held_out == held)),
            group=name,
        )
        for held, color, symbol, name in KINDS
    ]


def draw_formula_bars(
    axes: Axes,
    names: Sequence[str],
    values: Array,
    valid: Sequence[bool],
    label: str,
    beside: float | None,
) -> None:
    """Draw a bar for each formula, pale where it does not apply, and a line for finite elements.

    Parameters
    ----------
    values : (n,) array
        In the unit of the axis.
    label : str
        Of the lying axis, with its unit.
    beside : float or None
        By finite elements, in the unit of the axis.
    """
    from matplotlib.patches import Patch

    draw_rows(axes, names, values, label, colors=[BLUE if usable else PALE for usable in valid])
    handles: list[Any] = [Patch(color=BLUE, label="applies to the throw")]
    if not all(valid):
        handles.append(Patch(color=PALE, label="does not apply"))
    if beside is not None:
        handles.append(axes.axvline(beside, color="black", linewidth=1.8, label="finite elements"))
    axes.legend(
        frameon=False, handles=handles, fontsize=8, loc="upper left", bbox_to_anchor=(1.0, 1.0)
    )


# Bars of a Pareto diagram: what comes after them is hardly seen.
BARS = 16


def draw_effects(axes: Axes, names: Sequence[str], values: Array, label: str, form: str) -> None:
    """Draw the coded coefficients of a form in the order of their size (Pareto).

    Parameters
    ----------
    names : sequence of n str
        Terms, the largest first, as written on the axis.
    values : (n,) array
        In the unit of the axis.
    label : str
        Of the axis, with its unit.
    form : str
        For the title.
    """
    from matplotlib.patches import Patch

    shown = values[:BARS]
    draw_rows(
        axes,
        names[:BARS],
        np.abs(shown),
        label,
        colors=[BLUE if value >= 0.0 else ORANGE for value in shown],
        texts=[f"{value:+.3g}" for value in shown],
    )
    kinds = (("positive", BLUE, shown >= 0.0), ("negative", ORANGE, shown < 0.0))
    handles = [Patch(color=color, label=text) for text, color, those in kinds if those.any()]
    axes.legend(handles=handles, frameon=False, fontsize=8, loc="lower right")
    rest = len(values) - len(shown)
    more = f", {rest} smaller ones left out" if rest > 0 else ""
    write_title(axes, f"{form}: effects{more}", 10)
