"""Pictures of a whole crankshaft's modes and of its coupled vibration."""

from pathlib import Path
from typing import Any

import numpy as np

from crankfem.record import RPM
from dynamics.checks import FloatArray
from dynamics.crankshaft.coupled_response import CoupledResponse
from dynamics.crankshaft.shaft_modes import ShaftModes
from dynamics.crankshaft.shaft_throw import RZ, UX, UY, UZ
from geometry.diagram_style import BLUE, COLORS, GRAY, GREEN, ORANGE, RED, figure, with_gaps
from geometry.errors import InputError

MODES_SHOWN = 5


def plot_shaft_modes(
    path: Path, modes: ShaftModes, radius: float, count: int = MODES_SHOWN
) -> None:
    """Plot axial, torsional and lateral motion along the shaft for the first elastic modes.

    Parameters
    ----------
    path : Path
        Ends in .svg.
    modes : ShaftModes
    radius : float
        Crank radius: rotation about the shaft is shown as the displacement there [m].
    count : int
        How many modes.

    Raises
    ------
    InputError
        If the path does not end in .svg or has no folder, or there is no elastic mode.
    """
    shown = range(modes.rigid, min(modes.rigid + count, len(modes.names)))
    if not shown:
        raise InputError(
            f"count: given {count}; allowed is 1 or more of {len(modes.names) - modes.rigid} elastic modes, "
            "because a picture shows some."
        )
    # Sections and pins by place; end bodies stand where their section does, or beyond.
    order = np.argsort(modes.positions, kind="stable")
    places = 1e3 * modes.positions[order]
    with figure(path, len(shown), width=2.6 * len(shown), height=3.6) as axes:
        for one, mode in zip(np.atleast_1d(axes), shown, strict=True):
            motion = modes.motions[order, :, mode]
            curves = {
                "axial": motion[:, UZ],
                "torsional, at the crank radius": radius * motion[:, RZ],
                "lateral, x": motion[:, UX],
                "lateral, y": motion[:, UY],
            }
            largest = max(float(np.abs(curve).max()) for curve in curves.values())
            sign = _sign(list(curves.values()))
            one.axhline(0.0, color=GRAY, linewidth=1.0)
            for (name, curve), color, line in zip(
                curves.items(), (BLUE, ORANGE, GREEN, GREEN), ("-", "-", "-", "--"), strict=True
            ):
                one.plot(
                    places,
                    sign * curve / largest,
                    line,
                    color=color,
                    marker="o",
                    markersize=2.5,
                    linewidth=1.4,
                    label=name,
                )
            one.set_ylim(-1.1, 1.1)
            one.set_title(
                f"{modes.frequencies[mode]:.1f} Hz\n" + modes.label(mode).replace(", ", "\n"),
                fontsize=9,
            )
            one.set_xlabel("place along the shaft [mm]")
            _pad_title(one, modes.label(mode))
        first = np.atleast_1d(axes)[0]
        first.set_ylabel("relative displacement")
        handles, names = first.get_legend_handles_labels()
        first.figure.legend(handles, names, fontsize=8, loc="outside lower center", ncols=4)


def plot_axial_split(path: Path, response: CoupledResponse) -> None:
    """Plot the free end's axial amplitude by tangential forces, by radial forces and by both.

    Parameters
    ----------
    path : Path
        Ends in .svg.
    response : CoupledResponse

    Raises
    ------
    InputError
        If the path does not end in .svg or has no folder.
    """
    split = response.split("section 0 uz")
    speeds = response.speeds * RPM
    with figure(path, height=3.8) as axes:
        for values, name, color in (
            (split.both_sum, "all forces", RED),
            (split.tangential_sum, "tangential forces alone", ORANGE),
            (split.radial_sum, "radial forces alone", BLUE),
        ):
            axes.plot(speeds, with_gaps(1e6 * values), color=color, linewidth=1.5, label=name)
        axes.set_xlabel("crankshaft speed [1/min]")
        axes.set_ylabel("axial amplitude of the free end [um]")
        axes.set_ylim(bottom=0.0)
        axes.set_xlim(speeds[0], speeds[-1])
        axes.set_title(
            "half the range over the working cycle, all orders together",
            fontsize=9,
        )
        axes.legend(fontsize=8)


def plot_mode_shares(path: Path, modes: ShaftModes, count: int = 12) -> None:
    """Plot the axial, torsional and bending shares of the first elastic modes as bars.

    Parameters
    ----------
    path : Path
        Ends in .svg.
    modes : ShaftModes
    count : int
        How many modes.

    Raises
    ------
    InputError
        If the path does not end in .svg or has no folder.
    """
    shown = slice(modes.rigid, modes.rigid + count)
    shares = 100.0 * modes.shares[:, shown]
    rows = np.arange(shares.shape[1])
    with figure(path, height=0.9 + 0.28 * len(rows)) as axes:
        left = np.zeros(len(rows))
        for values, name, color in zip(
            shares, ("axial", "torsional", "bending"), COLORS[:3], strict=True
        ):
            axes.barh(rows, values, left=left, color=color, label=name, height=0.7)
            left = left + values
        axes.set_yticks(rows, [f"{value:.1f} Hz" for value in modes.frequencies[shown]], fontsize=8)
        axes.invert_yaxis()
        axes.set_xlim(0.0, 100.0)
        axes.set_xlabel("share of the mode's energy [%]")
        axes.grid(visible=False, axis="y")
        axes.legend(fontsize=8, loc="center left", bbox_to_anchor=(1.0, 0.5))


def _sign(curves: list[FloatArray]) -> float:
    """Return the sign that makes the largest displacement positive."""
    every = np.concatenate(curves)
    return float(np.sign(every[np.argmax(np.abs(every))])) or 1.0


def _pad_title(axes: Any, label: str) -> None:
    """Give titles of fewer lines the height of those with three classes, so that axes align."""
    axes.title.set_linespacing(1.15)
    missing = 2 - label.count(",")
    axes.set_title(axes.get_title(loc="left") + "\n" * missing, loc="left", fontsize=9)
