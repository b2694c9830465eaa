"""Diagrams of an elastic hinge: its moment, its guides, and the speed over a turn."""

from pathlib import Path

import numpy as np

from crankbase.drawing.diagram_style import figure, make_folder
from crankfem.analyses.hinge.hinge_run import HingeRun

# Files of the diagrams; that of the guides is written where springs are compared.
FILES, GUIDES = ("hinge_moment.svg", "hinge_speed.svg"), "hinge_guides.svg"


def plot_hinge(folder: Path, run: HingeRun) -> list[Path]:
    """Write all diagrams into a folder, which is made if it is not there.

    Parameters
    ----------
    folder : Path
    run : HingeRun

    Returns
    -------
    list of Path

    Raises
    ------
    InputError
        If the folder cannot be made.
    """
    make_folder(folder)
    made = [folder / name for name in FILES]
    plot_moments(made[0], run)
    plot_speeds(made[1], run)
    if run.compared:
        made.append(folder / GUIDES)
        plot_guides(made[-1], run)
    return made


def plot_moments(path: Path, run: HingeRun) -> None:
    """Plot gas force and hinge moment of all running points, and the moments of the same guides."""
    with figure(path, columns=2, width=9.6, height=4.4) as (left, right):
        run.plot(left, show="gas force")
        run.plot(right, show="moment")


def plot_guides(path: Path, run: HingeRun) -> None:
    """Plot the rollers' path for all compared springs, one panel for each size."""
    count = len(run.spring_sizes)
    with figure(path, columns=count, width=4.6 * count, height=4.9) as found:
        for size, panel in enumerate(np.atleast_1d(found)):
            run.plot_guides(panel, size)


def plot_speeds(path: Path, run: HingeRun) -> None:
    """Plot the speed over a turn: with the hinge, with a flywheel, and without either."""
    with figure(path) as axes:
        run.plot(axes, show="speed")
