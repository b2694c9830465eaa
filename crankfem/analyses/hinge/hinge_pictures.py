"""Diagrams of an elastic hinge: its moment, its guides, and the speed over a revolution."""

from pathlib import Path

import numpy as np

from crankbase.drawing.diagram_style import figure, make_folder
from crankfem.analyses.hinge.hinge_run import HingeRun

# Files of the diagrams; that of the guides is written where springs are compared, that of their surface
# where rollers have a radius.
FILES, GUIDES = ("hinge_moment.svg", "hinge_speed.svg"), "hinge_guides.svg"
SURFACE = "hinge_surface.svg"


def plot_hinge(folder: Path, run: HingeRun) -> list[Path]:
    """Write all diagrams into a folder, which is created if necessary.

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
    with figure(made[0], columns=2, width=9.6, height=4.4) as (left, right):
        run.plot(left, show="gas force")
        run.plot(right, show="moment")
    with figure(made[1]) as axes:
        run.plot(axes, show="speed")
    if run.compared:
        made.append(folder / GUIDES)
        count = len(run.spring_sizes)
        with figure(made[-1], columns=count, width=4.6 * count, height=4.9) as panels:
            for size, panel in enumerate(np.atleast_1d(panels)):
                run.plot_guides(panel, size)
    if run.surface is not None:
        made.append(folder / SURFACE)
        with figure(made[-1], width=6.4, height=6.8) as axes:
            run.profile.plot(axes)
    return made
