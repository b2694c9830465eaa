"""The figures of a report: static pictures and, where there are some, interactive plots beside them."""

import base64
import errno
import gzip
import io
import json
import re
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from PIL import Image

from crankbase.array_checks import Array
from crankbase.outputs import is_regular_file
from crankfem.analyses.mechanism.plots import plot_torque
from crankfem.analyses.run_results import RunResults
from crankfem.analyses.study.fit_plots import plot_effects, plot_parity, plot_response
from crankfem.analyses.study.response_fits import ResponseFits
from crankfem.report.interactive.mechanism import MECHANISM
from crankfem.report.interactive.plot import Plot, Plots, plot_of_curves
from crankfem.report.interactive.study import parity, response_over_factors
from crankfem.report.interactive.vibration import VIBRATION
from dynamics.harmonics import Harmonics
from regression.runs.study_table import StudyTable

# What keeps the place of a packed picture, of its size.
EMPTY = "data:image/svg+xml,%3Csvg%20xmlns='http:%2F%2Fwww.w3.org/2000/svg'%20viewBox='0%200%20{}%20{}'/%3E"
# Of pictures without sharp edges, at which nothing is seen to be lost.
QUALITY = 85
POINT = 96.0 / 72.0  # [pixel]
VIEW_BOX = re.compile(rb'viewBox="\s*\S+\s+\S+\s+(\S+)\s+(\S+?)\s*"')


@dataclass(frozen=True)
class Figure:
    """A picture, an interactive plot, or both.

    Attributes
    ----------
    source : str or None
        The static picture as a data address; an empty one of its size where it is packed.
    width, height : int
        Of the static picture, without one of the interactive plot [pixel].
    drawing, plot : str or None
        A static SVG and the interactive plot as JSON, `packed`.
    """

    source: str | None = None
    width: int = 0
    height: int = 0
    drawing: str | None = None
    plot: str | None = None


def load_figures(
    pictures: Mapping[str, str], plots: Mapping[str, str], folder: Path
) -> tuple[dict[str, Figure], list[str]]:
    """Read figures.

    Parameters
    ----------
    pictures, plots : mapping
        Name of each static and each interactive figure to its file.
    folder : Path
        Where the files are, inside that of the run; nothing from elsewhere is read.

    Returns
    -------
    figures : dict
        Name to figure; of a figure of two files the one that can be read.
    unread : list of str
        Names of the files that are missing, are no pictures, or lie elsewhere.
    """
    figures, unread = {}, []
    for name in (*pictures, *(name for name in plots if name not in pictures)):
        drawn = Figure()
        if name in pictures:
            try:
                drawn = _drawn(_own_file(folder, pictures[name]))
            except (OSError, SyntaxError):
                unread.append(pictures[name])
        if name in plots:
            try:
                text = _own_file(folder, plots[name]).read_text(encoding="utf-8")
                plot = json.loads(text)  # the reader's browser would find what was cut short
                room = drawn.height or plot.get("layout", {}).get("height", 0)
                drawn = replace(drawn, plot=packed(text), height=room)
            except (OSError, ValueError):
                unread.append(plots[name])
        if drawn.source is not None or drawn.plot is not None:
            figures[name] = drawn
    return figures, unread


def _own_file(folder: Path, name: str) -> Path:
    """Return the path of a file that lies in the folder itself, and is no link out of it."""
    path = folder / name
    if path.name != name or "\\" in name or folder.is_symlink() or not is_regular_file(path):
        raise FileNotFoundError(errno.ENOENT, "is no file of the run's", str(path))
    return path


def packed(text: str) -> str:
    """Return a text as small as a page can hold it, for its own script to unpack: gzipped, in base64."""
    return base64.b64encode(gzip.compress(text.encode(), mtime=0)).decode()


def _drawn(path: Path) -> Figure:
    content = path.read_bytes()
    if path.suffix == ".svg":
        box = VIEW_BOX.search(content)
        width, height = (round(float(side) * POINT) for side in box.groups()) if box else (0, 0)
        return Figure(EMPTY.format(width, height), width, height, packed(content.decode()))
    with Image.open(io.BytesIO(content)) as picture, io.BytesIO() as smaller:
        picture.save(smaller, "WEBP", quality=QUALITY)
        text = base64.b64encode(smaller.getvalue()).decode()
        return Figure(f"data:image/webp;base64,{text}", picture.width, picture.height)


STUDY: Plots[tuple[StudyTable, ResponseFits]] = Plots(
    (
        Plot(
            "response",
            "Axial compliance over each factor",
            "Axial compliance over each factor, the others at their middle.",
            lambda path, study: plot_response(path, *study),
            lambda study: response_over_factors(*study),
        ),
        Plot(
            "parity",
            "Equation against finite elements for each form",
            "Each form against finite elements; on the line they agree.",
            lambda path, study: plot_parity(path, *study),
            lambda study: parity(*study),
        ),
        Plot(
            "effects",
            "Coded coefficients by size",
            "Effects: the coefficients of the chosen form in coded variables, by size.",
            lambda path, study: plot_effects(path, study[1], study[1].chosen),
        ),
    )
)


ANGLES: Plots[RunResults] = Plots(
    (
        plot_of_curves(
            "formulas",
            "Axial compliance over the angle between neighboring cranks",
            "Axial compliance over the angle between neighboring cranks: finite elements in a helix of equal "
            "throws, and the formulas. Formulas without an angle are level lines.",
            lambda results: results.angle_law.curves(results.throw),
            lambda _: "Axial compliance, finite elements and formulas",
        ),
    )
)


TORQUE: Plots[tuple[Array, Harmonics]] = Plots(
    (
        Plot(
            "torque",
            "Torque over a cycle and its harmonics",
            "Torque of one throw with the sum of its harmonics, and the amplitude of each order.",
            lambda path, torque: plot_torque(path, *torque),
        ),
    )
)
# Those that are drawn or rendered on their own, for each throw or in the background.
THROW: tuple[Plot[None], ...] = (
    Plot(
        "throw_view",
        "The crank throw in three dimensions: solid, mesh, deformed by an axial force, fillet stress",
        "The throw in three dimensions: turn it with the mouse; the menu shows the solid, the mesh, its "
        "deformation by an axial force and the stress at the fillets.",
    ),
    Plot(
        "shaft_view",
        "The crankshaft in three dimensions, its throws in colors and its cuts as rings",
        "The crankshaft as it was read and cut: turn it with the mouse.",
    ),
    Plot(
        "drawing",
        "Dimensioned drawing of the crank throw: side view and view from the left end",
        "The throw as described in the file, to scale.",
    ),
    Plot(
        "stress_radial",
        "Equivalent stress of the crank throw under a radial force on the pin",
        "Under a radial force on the pin; a ring marks the largest stress at a fillet, a square that at an "
        "oil hole.",
    ),
    Plot(
        "stress_torsion", "Equivalent stress of the crank throw under a torque", "Under a torque."
    ),
)
PLOTS: dict[str, Plot[Any]] = {
    plot.name: plot
    for plots in (MECHANISM, STUDY, TORQUE, VIBRATION, ANGLES)
    for plot in plots.plots
} | {plot.name: plot for plot in THROW}
