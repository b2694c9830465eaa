"""Vibration over time with the speed below it, and amplitudes of one order over the speed."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from crankfem.pictures.titles import add_title
from crankfem.record import RPM
from dynamics.checks import finite_array, finite_vector, node_index
from dynamics.transient.run import TransientMotion
from dynamics.transient.turning_run import TurningRun
from geometry.diagram_style import BLUE, COLORS, GRAY, ORANGE, figure, with_gaps
from geometry.errors import InputError

Array = NDArray[np.float64]
# Columns of the band between extremes: more cannot be told apart in print.
COLUMNS = 600


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
    """Plot what one element or node does over time, its amplitude, and the speed below.

    Parameters
    ----------
    path : Path
        SVG file.
    run : TransientMotion or TurningRun
        Of a chain.
    place : int, optional
        Number of the element, or of the node, from 0.
    quantity : {"torque", "motion"}
        Torque in the spring of the element, or twist of the node.
    steady : (speeds [rad/s], amplitudes), optional
        Amplitudes at constant speeds, ascending, drawn where the run passes these speeds.
    turns : int, optional
        Of the shaft for which one amplitude is taken; by default after which the run repeats.
    title : str, optional

    Raises
    ------
    InputError
        If the run is not that of a chain, there is no such element or node, the run is shorter
        than one window of its envelope, or its orders have no common cycle and no turns are given.
    """
    chain = run.system.chain
    if chain is None or quantity not in ("torque", "motion"):
        raise InputError(
            f"quantity: given {quantity!r}; allowed are torque and motion of a run of a chain, because "
            "its elements and nodes have names."
        )
    torque = quantity == "torque"
    names, unit, factor = (chain.elements, "kN m", 1e-3) if torque else (chain.names, "mrad", 1e3)
    index = node_index("place", place, len(names))
    values = (run.torque if torque else run.motion)[:, index] * factor
    envelope = run.envelope(turns)
    amplitude = (envelope.torque if torque else envelope.motion)[:, index] * factor
    with figure(path, width=7.6, height=5.0) as axes:
        top, bottom = _two_rows(axes)
        edges, low, high = _extremes(run.time, values)
        top.fill_between(edges, low, high, color=BLUE, alpha=0.3, linewidth=0.0, label="extremes")
        top.plot(
            envelope.time,
            amplitude,
            color=BLUE,
            linewidth=1.6,
            label=_envelope_label(envelope.turns),
        )
        if steady is not None:
            top.plot(
                run.time,
                _passed(run.shaft_speed, steady) * factor,
                color=ORANGE,
                linestyle="--",
                linewidth=1.3,
                label="steady amplitude at this speed",
            )
        top.set_ylabel(f"{'torque' if torque else 'twist'} [{unit}]")
        top.set_title(names[index], fontsize=9)
        top.legend(fontsize=8, ncols=3, loc="lower right", bbox_to_anchor=(1.0, 1.0))
        top.tick_params(labelbottom=False)
        places = np.linspace(0, run.time.size - 1, COLUMNS).astype(int)
        bottom.plot(run.time[places], run.shaft_speed[places] * RPM, color=GRAY, linewidth=1.6)
        bottom.set_ylabel("speed [1/min]")
        bottom.set_xlabel("time [s]")
        bottom.set_xlim(run.time[0], run.time[-1])
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
    path : Path
        SVG file.
    speeds : array_like of shape (S,)
        [rad/s]
    amplitudes : mapping of str to array_like of shape (S,)
        What each curve is called, and its values; infinite ones leave a gap.
    label : str, optional
        Of the axis, with its unit.
    title : str, optional

    Raises
    ------
    InputError
        If there is no curve, or one does not fit the speeds.
    """
    along = finite_vector("speeds", speeds) * RPM
    if not amplitudes:
        raise InputError(
            "amplitudes: given none; allowed are one or more, because they are what is drawn."
        )
    with figure(path, width=7.2, height=3.8) as axes:
        for place, (name, values) in enumerate(amplitudes.items()):
            curve = np.asarray(values, dtype=np.float64)
            if curve.shape != along.shape or np.any(np.isnan(curve)):
                raise InputError(
                    f"amplitudes[{name!r}]: given an array of shape {curve.shape}; allowed are "
                    f"{along.size} numbers, because there is one for each speed."
                )
            axes.plot(
                along,
                with_gaps(curve),
                color=COLORS[place % len(COLORS)],
                linestyle="-" if place == 0 else "--",
                linewidth=1.8,
                label=name,
            )
        axes.set_xlim(along[0], along[-1])
        axes.set_ylim(bottom=0.0)
        axes.set_xlabel("crankshaft speed [1/min]")
        axes.set_ylabel(label)
        axes.legend(fontsize=8)
        add_title(axes, title)


def _two_rows(axes: Any) -> tuple[Any, Any]:
    """Replace the axes of a figure by a high one and a low one below it."""
    grid = axes.get_subplotspec().subgridspec(2, 1, height_ratios=(2.4, 1.0))
    drawn = axes.figure
    axes.remove()
    top = drawn.add_subplot(grid[0])
    return top, drawn.add_subplot(grid[1], sharex=top)


def _extremes(time: Array, values: Array) -> tuple[Array, Array, Array]:
    """Return times and the extremes of the values around them, few enough for a small file."""
    columns = min(COLUMNS, time.size)
    starts = np.unique(np.linspace(0, time.size, columns, endpoint=False).astype(int))
    return time[starts], np.minimum.reduceat(values, starts), np.maximum.reduceat(values, starts)


def _passed(speed: Array, steady: tuple[ArrayLike, ArrayLike]) -> Array:
    """Return steady amplitudes at the speeds of a run, not a number outside of what is known."""
    known, amplitude = (finite_array("steady", values) for values in steady)
    if known.ndim != 1 or known.shape != amplitude.shape or np.any(np.diff(known) <= 0.0):
        raise InputError(
            f"steady: given arrays of shapes {known.shape} and {amplitude.shape}; allowed are ascending "
            "speeds and an amplitude for each, because they are drawn over the speeds of the run."
        )
    return np.interp(speed, known, amplitude, left=np.nan, right=np.nan)


def _envelope_label(turns: int) -> str:
    return f"amplitude over {'each turn' if turns == 1 else f'{turns} turns'}"
