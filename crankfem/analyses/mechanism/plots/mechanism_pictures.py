"""Diagrams of a crank mechanism that need more than one of its parts."""

from pathlib import Path

from crankbase.drawing.diagram_style import figure
from crankbase.drawing.legends import plain_text
from crankfem.analyses.mechanism.mechanism_run import MechanismRun
from crankfem.analyses.titles import at_speed


def plot_piston_forces(path: Path, run: MechanismRun, cylinder: int = 1) -> None:
    """Plot gas force, side force and tangential force of a cylinder over the cycle, as SVG.

    Parameters
    ----------
    path : Path
    run : MechanismRun
    cylinder : int, optional
        Its number, from 1.
    """
    with figure(path) as axes:
        run.forces.plot(axes, cylinder)
        engine = plain_text(at_speed(run.mechanism.name, run.speed))
        axes.set_title(f"cylinder {cylinder}, {engine}")
