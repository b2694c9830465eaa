"""Polar load diagrams of crankpins and main bearings."""

from collections.abc import Sequence
from pathlib import Path

from crankbase.drawing.diagram_style import figure
from crankbase.drawing.legends import plain_text
from crankbase.errors import InputError
from dynamics.engine.loads import LoadDiagram
from dynamics.plots.load_diagrams import Frame, check_polar, draw_polar_loads


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
        For the legend; the diagrams' names otherwise.
    frame : str, optional
        "crank": turning with the crank, which stands upright, tangential force to the right, radial
        force (towards the shaft) down. "engine": at rest, y up, seen from the free end, where the
        shaft turns clockwise and x points to the left.
    mark_step_deg : float, optional
        A dot on the first curve at every such step of shaft angle [deg], with its angle where there
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
