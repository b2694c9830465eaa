"""Pictures of a whole crankshaft's modes."""

from pathlib import Path
from typing import Any

import numpy as np

from crankbase.drawing.diagram_style import figure
from crankbase.errors import InputError
from dynamics.crankshaft.shaft_modes import ShaftModes
from dynamics.plots.mode_shapes import draw_shaft_shape

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
    modes : ShaftModes
    radius : float
        Crank radius: rotation about the shaft is shown as the displacement there [m].
    count : int
        Number of modes.

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
        for one, mode in zip(axes.flat, shown, strict=False):
            draw_shaft_shape(one, places, modes.motions[order, :, mode], radius)
            one.set_title(
                f"{modes.frequencies[mode]:.1f} Hz\n" + modes.label(mode).replace(", ", "\n"),
                fontsize=9,
            )
            _pad_title(one, modes.label(mode))
        for left in axes[:, 0]:
            left.set_ylabel("relative displacement")
        first = axes[0, 0]
        handles, names = first.get_legend_handles_labels()
        first.figure.legend(handles, names, fontsize=8, loc="outside lower center", ncols=4)


def _pad_title(axes: Any, label: str) -> None:
    """Give titles of fewer lines the height of those with three classes, so that axes align."""
    axes.title.set_linespacing(1.15)
    missing = 2 - label.count(",")
    axes.set_title(axes.get_title(loc="left") + "\n" * missing, loc="left", fontsize=9)
