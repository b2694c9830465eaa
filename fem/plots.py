"""Compliances of a throw over the angle between neighboring cranks."""

from collections.abc import Mapping, Sequence
from typing import Literal

import numpy as np

from crankbase.array_checks import Array
from crankbase.diagrams import BLUE, COLORS, new_axes, write_title
from crankbase.errors import InputError
from crankbase.frames import Axes
from crankbase.quantity import percent


def draw_frequencies(axes: Axes, frequencies: Array, kinds: Sequence[str], title: str) -> None:
    """Draw a stem for each frequency, colored by its kind.

    Parameters
    ----------
    frequencies : (n,) array
        [Hz]
    kinds : sequence of n str
        For the legend.
    """
    numbers = np.arange(1, len(frequencies) + 1)
    for place, kind in enumerate(dict.fromkeys(kinds)):
        here = np.array([mode_kind == kind for mode_kind in kinds])
        color = COLORS[place % len(COLORS)]
        axes.vlines(numbers[here], 0.0, frequencies[here], color=color, linewidth=1.2)
        axes.plot(numbers[here], frequencies[here], "o", color=color, markersize=5, label=kind)
    if len(numbers) <= 20:
        axes.set_xticks(numbers)
    axes.set_ylim(bottom=0.0)
    axes.set_xlabel("number")
    axes.set_ylabel("natural frequency [Hz]")
    write_title(axes, title)
    if len(numbers):
        axes.legend(frameon=False, fontsize=8, loc="upper left", bbox_to_anchor=(1.0, 1.0))


Compliance = Literal["axial_compliance", "torsional_compliance", "influence_coefficient"]

ANGLE_LABEL = r"angle between neighboring cranks $\gamma$ [deg]"
# Label of each quantity's axis, in units of 1e-9 of its SI unit.
LABELS: dict[Compliance, str] = {
    "axial_compliance": r"axial compliance $e_\mathrm{n}$ [$10^{-9}$ m/N]",
    "torsional_compliance": r"torsional compliance $e_\mathrm{t}$ [$10^{-9}$ rad/(N m)]",
    "influence_coefficient": r"influence coefficient $c$ [$10^{-9}$ m/N]",
}
SHOWN = 1e9
ANGLES_DEG = np.arange(0.0, 181.0, 5.0)


def check_compliance(quantity: str) -> Compliance:
    """Return the quantity.

    Raises
    ------
    InputError
        If it is none that is drawn over the angle.
    """
    for name in LABELS:
        if name == quantity:
            return name
    raise InputError(
        f"quantity: given {quantity!r}; allowed are {', '.join(LABELS)}, because these depend on the "
        "throw's support."
    )


def draw_supports(axes: Axes, bounds: Mapping[str, float]) -> None:
    """Draw a line across the axes for each support's value [SI], with its name."""
    for text, value in bounds.items():
        axes.axhline(value * SHOWN, color="black", linewidth=0.8, linestyle=":")
        axes.annotate(
            text, (0.0, value * SHOWN), xytext=(2, 3), textcoords="offset points", fontsize=8
        )


def angle_axis(axes: Axes) -> None:
    """Give the axes the angle from 0 to 180 deg, and its name."""
    axes.set_xlim(0.0, 180.0)
    axes.set_xticks(np.arange(0, 181, 30))
    axes.set_xlabel(ANGLE_LABEL)


def plot_compliance(
    axes: Axes | None,
    values: Array,
    bounds: Mapping[str, float],
    quantity: Compliance,
    error: float | None,
) -> Axes:
    """Draw a throw's compliance over the angle to equal neighbors.

    Parameters
    ----------
    axes : matplotlib.axes.Axes or None
        New ones for None.
    values : (37,) array
        At `ANGLES_DEG` [SI].
    bounds : mapping of str to float
        Values under other supports, by their names [SI].
    error : float or None
        Estimated relative error.
    """
    axes = new_axes(axes)
    shown = values * SHOWN
    axes.plot(ANGLES_DEG, shown, color=BLUE, label="between equal neighbors")
    if error is not None:
        axes.fill_between(
            ANGLES_DEG,
            shown * (1.0 - error),
            shown * (1.0 + error),
            color=BLUE,
            alpha=0.2,
            linewidth=0.0,
            label=f"estimated error, {percent(error, 2)} %",
        )
    draw_supports(axes, bounds)
    ends = np.concatenate([shown, SHOWN * np.array(list(bounds.values()))])
    axes.set_ylim(min(0.0, 1.1 * float(ends.min())), 1.1 * float(ends.max()))
    angle_axis(axes)
    axes.set_ylabel(LABELS[quantity])
    axes.legend(frameon=False, fontsize=8, loc="lower right")
    write_title(axes, "Throw by finite elements")
    return axes
