"""Polar load diagrams of crankpins and main bearings."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from crankbase.drawing.diagram_style import GRAY, GREEN, RED, figure
from crankbase.drawing.legends import legend_below, plain_text
from crankbase.errors import InputError
from crankfem.analyses.mechanism.rod_comparison import ModelDifference
from crankfem.analyses.titles import add_title
from dynamics.engine.loads import LoadDiagram
from dynamics.plots.load_diagrams import Frame, check_polar, draw_polar_loads
from dynamics.plots.quantities import KILO


def plot_polar_loads(
    path: Path,
    diagrams: Sequence[LoadDiagram],
    *,
    labels: Sequence[str] | None = None,
    frame: Frame = "crank",
    mark_step_deg: float = 30.0,
    title: str = "",
) -> None:
    """Plot the locus of a bearing's force vector, one curve for each diagram, as SVG.

    Parameters
    ----------
    path : Path
    diagrams : sequence of LoadDiagram
        Of one bearing with several models or at several operating points, to compare.
    labels : sequence of str, optional
        For the legend; by default the diagrams' names.
    frame : str, optional
        "crank": turning with the crank, which is upright, tangential force to the right, radial
        force (towards the shaft) down. "engine": fixed, y up, seen from the free end, where the
        shaft turns clockwise and x points to the left.
    mark_step_deg : float, optional
        Interval of the dots on the first curve in shaft angle [deg], labeled with the angle where there
        is room.
    title : str, optional

    Raises
    ------
    InputError
        If there is no diagram, or labels, frame or step do not fit.
    """
    if not diagrams:
        raise InputError(
            "diagrams: given none; allowed are one or more, because a picture shows something."
        )
    names = [diagram.name for diagram in diagrams] if labels is None else list(labels)
    if len(names) != len(diagrams):
        raise InputError(
            f"labels: given {len(names)} for {len(diagrams)} diagrams; allowed is one for each, because "
            "every curve has its name."
        )
    loads = list(zip(names, diagrams, strict=True))
    check_polar(frame, mark_step_deg)
    with figure(path, width=6.4, height=6.4) as axes:
        draw_polar_loads(axes, loads, frame, mark_step_deg)
        if title:
            axes.set_title(plain_text(title))


def plot_model_difference(path: Path, found: ModelDifference, *, title: str = "") -> None:
    """Plot the crankpin load by two rod models, and their difference over the shaft angle.

    Parameters
    ----------
    path : Path
        Of the SVG file.
    found : ModelDifference
    title : str, optional
        Above both panels.
    """
    per_piston = 1e-6 / (KILO * found.piston_area)  # MPa for each kN
    with figure(path, 2, width=11.8, height=6.4) as (polar, shares):
        loads = list(zip(found.models, (found.first, found.second), strict=True))
        draw_polar_loads(polar, loads, "crank", 30.0)
        scale = (lambda force: force * per_piston, lambda pressure: pressure / per_piston)
        for side, axis in (("top", "xaxis"), ("right", "yaxis")):
            second = getattr(polar, f"secondary_{axis}")(side, functions=scale)
            second.set(**{f"{axis[0]}label": "force over piston area [MPa]"})
        degrees = found.first.angles_deg
        for values, color, name in (
            (found.of_same_angle, RED, "of the size at the same angle"),
            (found.of_mean, GREEN, "of the mean size"),
        ):
            shares.plot(degrees, 100.0 * values, color=color, linewidth=1.3, label=name)
        shares.axhline(0.0, color=GRAY, linewidth=0.8)
        shares.set_xlim(degrees[0], 2.0 * degrees[-1] - degrees[-2])
        shares.set_xticks(np.arange(0.0, degrees[-1] + 90.0, 90.0))
        shares.set_xlabel("shaft angle [deg]")
        shares.set_ylabel(f"force, {found.models[1]} less {found.models[0]} [%]")
        legend_below(shares, 2)
        add_title((polar, shares), title)
