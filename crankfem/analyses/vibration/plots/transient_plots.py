"""Vibration over time with the speed below it, and amplitudes of one order over the speed."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike

from crankbase.checks.arrays import finite_vector
from crankbase.drawing.diagram_style import figure
from crankbase.errors import InputError
from crankfem.analyses.titles import add_title
from crankfem.analyses.vibration.run import EngineVibration
from crankfem.analyses.vibration.run_up import RunUp
from dynamics.plots.curves import draw_named_curves, draw_speed
from dynamics.transient.motions import Moving
from dynamics.transient.run import TransientMotion
from dynamics.transient.turning_run import TurningRun


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
        Revolutions of the shaft for one amplitude; by default those after which the run repeats.
    title : str, optional

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
        top, bottom = _two_rows(axes)
        run.plot(top, place, quantity=moving, steady=steady, turns=turns)
        top.set_xlabel("")
        top.tick_params(labelbottom=False)
        draw_speed(bottom, run.time, run.shaft_speed)
        add_title((top, bottom), title)


def picture_run_up(path: Path, run: EngineVibration, found: RunUp) -> None:
    """Draw the torque in the spring with the largest one, and its amplitude at constant speeds."""
    forced = run.forced_torsional
    assert forced is not None
    elastic = forced.loads.elastic
    plot_transient(
        path,
        found.motion,
        found.worst,
        steady=(elastic.speeds, elastic.synthesis.amplitude[:, found.worst]),
        title=f"{run.engine_file.engine.name}, run-up in {found.duration:g} s",
    )


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
        Name of each curve, and its values; infinite ones leave a gap.
    label : str, optional
        Of the axis, with its unit.
    title : str, optional

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


def _two_rows(axes: Any) -> tuple[Any, Any]:
    """Replace the axes of a figure by a high one and a low one below it."""
    grid = axes.get_subplotspec().subgridspec(2, 1, height_ratios=(2.4, 1.0))
    drawn = axes.figure
    axes.remove()
    top = drawn.add_subplot(grid[0])
    return top, drawn.add_subplot(grid[1], sharex=top)
