"""Diagrams of an engine's vibration: responses, transients, and modes of the whole crankshaft."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from crankbase.array_checks import finite_array, finite_vector
from crankbase.diagrams import draw_diagram, figure
from crankbase.errors import InputError
from crankfem.analyses.titles import add_title
from dynamics.crankshaft.shaft_modes import ShaftModes
from dynamics.plots.campbell import Meeting, draw_campbell
from dynamics.plots.curves import draw_named_curves, draw_speed
from dynamics.plots.mode_shapes import shaft_shape
from dynamics.transient.motions import Moving, TransientMotion
from dynamics.transient.turning_run import TurningRun

MODES_SHOWN = 5
# Of one row; more would be unreadable on paper.
COLUMNS = 3


def plot_shaft_modes(
    path: Path, modes: ShaftModes, radius: float, count: int = MODES_SHOWN
) -> None:
    """Plot axial, torsional and lateral motion along the shaft for the first elastic modes.

    Parameters
    ----------
    path : Path
        Ends in .svg.
    radius : float
        Crank radius: rotation about the shaft is shown as the displacement there [m].

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
    places = modes.positions[order]
    columns = min(COLUMNS, len(shown))
    rows = -(-len(shown) // columns)
    with figure(path, columns, width=2.6 * columns, height=0.5 + 3.1 * rows, rows=rows) as axes:
        for spare in axes.flat[len(shown) :]:
            spare.remove()
        for panel, mode in zip(axes.flat, shown, strict=False):
            draw_diagram(panel, shaft_shape(places, modes.motions[order, :, mode], radius))
            panel.set_ylabel("")
            label = modes.label(mode)
            title = f"{modes.frequencies[mode]:.1f} Hz\n" + label.replace(", ", "\n")
            panel.set_title(title, fontsize=9)
            # Titles of fewer lines have the height of those with three classes, so that axes align.
            panel.title.set_linespacing(1.15)
            panel.set_title(
                panel.get_title(loc="left") + "\n" * (2 - label.count(",")), loc="left", fontsize=9
            )
        for left in axes[:, 0]:
            left.set_ylabel("relative displacement")
        first = axes[0, 0]
        handles, names = first.get_legend_handles_labels()
        first.figure.legend(handles, names, fontsize=8, loc="outside lower center", ncols=4)


def plot_response_campbell(
    path: Path,
    frequencies: ArrayLike,
    orders: ArrayLike,
    speed_range: tuple[float, float],
    meetings: Sequence[Meeting],
    *,
    title: str = "",
) -> None:
    """Plot natural frequencies and order lines over speed, with a dot at each resonance.

    Parameters
    ----------
    path : Path
        SVG file.
    frequencies : array_like of shape (n,)
        Natural frequencies of elastic modes [Hz]; those above the range of the orders are left out.
    orders : array_like of shape (K,)
        In cycles per crankshaft revolution.
    speed_range : tuple of two floats
        Running range [rad/s].
    meetings : sequence of Meeting
        For example `Resonance`; dots grow with their severity.

    Raises
    ------
    InputError
        If the path is not an SVG file in an existing folder.
    """
    natural, lines = finite_array("frequencies", frequencies), finite_array("orders", orders)
    with figure(path, height=4.8) as axes:
        draw_campbell(axes, natural, lines, speed_range, meetings)
        add_title(axes, title)


def plot_transient(
    path: Path,
    run: TransientMotion | TurningRun,
    place: int = 0,
    *,
    quantity: Literal["torque", "motion"] = "torque",
    steady: tuple[ArrayLike, ArrayLike] | None = None,
    turns: int | None = None,
    title: str = "",
) -> None:
    """Plot the motion or load of one element or node over time, its amplitude, and the speed below.

    Parameters
    ----------
    place : int, optional
        Number of the element, or of the node, from 0.
    quantity : {"torque", "motion"}
        Torque in the spring of the element, or twist of the node.
    steady : (speeds [rad/s], amplitudes), optional
        Amplitudes at constant speeds, ascending, drawn where the run passes these speeds.
    turns : int, optional
        Revolutions of the shaft for one amplitude; by default those after which the run repeats.

    Raises
    ------
    InputError
        If the run is not that of a chain, there is no such element or node, the run is shorter
        than one window of its envelope, or its orders have no common cycle and no turns are given.
    """
    if quantity not in ("torque", "motion"):
        raise InputError(
            f"quantity: given {quantity!r}; allowed are torque and motion, because a run has these."
        )
    moving: Moving = "torque" if quantity == "torque" else "twist"
    with figure(path, width=7.6, height=5.0) as axes:
        # A high one and a low one below it replace the axes of the figure.
        grid = axes.get_subplotspec().subgridspec(2, 1, height_ratios=(2.4, 1.0))
        drawn = axes.figure
        axes.remove()
        top = drawn.add_subplot(grid[0])
        bottom = drawn.add_subplot(grid[1], sharex=top)
        run.plot(top, place, quantity=moving, steady=steady, turns=turns)
        top.set_xlabel("")
        top.tick_params(labelbottom=False)
        draw_speed(bottom, run.time, run.shaft_speed)
        add_title((top, bottom), title)


def plot_transient_over_speed(
    path: Path,
    speeds: ArrayLike,
    amplitudes: Mapping[str, ArrayLike],
    *,
    label: str = "amplitude",
    title: str = "",
) -> None:
    """Plot amplitudes over the speed, such as those of one order by different models.

    Parameters
    ----------
    speeds : array_like of shape (S,)
        [rad/s]
    amplitudes : mapping of str to array_like of shape (S,)
        Name of each curve, and its values; infinite ones leave a gap.
    label : str, optional
        Of the axis, with its unit.

    Raises
    ------
    InputError
        If there is no curve, or one does not fit the speeds.
    """
    along = finite_vector("speeds", speeds)
    if not amplitudes:
        raise InputError(
            "amplitudes: given none; allowed are one or more, because they are what is drawn."
        )
    curves = {}
    for name, values in amplitudes.items():
        curve = np.asarray(values, dtype=np.float64)
        if curve.shape != along.shape or np.any(np.isnan(curve)):
            raise InputError(
                f"amplitudes[{name!r}]: given an array of shape {curve.shape}; allowed are "
                f"{along.size} numbers, because there is one for each speed."
            )
        curves[name] = curve
    with figure(path, width=7.2, height=3.8) as axes:
        draw_named_curves(axes, along, curves, label, dashed=True)
        add_title(axes, title)
