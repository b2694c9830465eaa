"""The common style of all diagrams, without changing the user's plot settings."""

import re
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from crankbase.errors import InputError
from crankbase.outputs import atomic_file, check_output

if TYPE_CHECKING:
    from matplotlib.axes import Axes

# Files that are the same bit for bit for the same picture, with no need of the reader's fonts.
REPRODUCIBLE: dict[Any, Any] = {"svg.fonttype": "path", "svg.hashsalt": "crankfem"}
STYLE: dict[Any, Any] = {
    **REPRODUCIBLE,
    "font.size": 10,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "grid.color": "#e3e7ec",
    "grid.linewidth": 0.8,
    "axes.axisbelow": True,
    "legend.frameon": False,
    "axes.titlesize": 11,
    "axes.titlelocation": "left",
}
BLUE, ORANGE, GREEN, RED, GRAY = "#1f5f99", "#d9822b", "#3a8f5c", "#b63b3b", "#7b8794"
COLORS = (BLUE, ORANGE, GREEN, RED, "#7a5ba6", GRAY)


@contextmanager
def figure(
    path: Path,
    columns: int = 1,
    width: float = 7.2,
    height: float = 4.2,
    *,
    rows: int | None = None,
) -> Iterator[Any]:
    """Yield the axes of a figure and write it as SVG to `path`; with `rows`, an array (rows, columns).

    Raises
    ------
    InputError
        If the file is not called .svg, has no folder, or is not ours.
    """
    path = Path(path)
    if path.suffix.lower() != ".svg" or not path.parent.is_dir():
        raise InputError(
            f"path: given {path}; allowed is a file name that ends in .svg in an existing folder, "
            "because diagrams are written as SVG."
        )
    check_output(path, "picture")
    import matplotlib as mpl
    from matplotlib.backends.backend_svg import FigureCanvasSVG
    from matplotlib.figure import Figure

    with mpl.rc_context(STYLE):
        made = Figure(figsize=(width, height), layout="constrained")
        FigureCanvasSVG(made)
        axes = made.subplots(rows or 1, columns, squeeze=rows is None)
        yield axes
        # Laid out once; `savefig` would draw everything another time for it.
        layout = made.get_layout_engine()
        assert layout is not None
        layout.execute(made)
        made.set_layout_engine(None)
        with atomic_file(path, "picture") as part:
            made.savefig(part, metadata={"Date": None})


def new_axes(axes: "Axes | None" = None, *, width: float = 7.2, height: float = 4.2) -> "Axes":
    """Return the axes to draw on: those given, or those of a new figure in the style of all diagrams.

    Parameters
    ----------
    axes : matplotlib.axes.Axes, optional
    width, height : float
        Of a new figure [inch].

    Returns
    -------
    matplotlib.axes.Axes
        A new figure is one of pyplot's, shown by ``plt.show()``.
    """
    if axes is not None:
        return axes
    import matplotlib as mpl
    from matplotlib import pyplot

    # Outside of the context: the first figure selects the backend, and the inline one of notebooks then
    # turns on interactive drawing, which the context would turn off again.
    made = pyplot.figure(figsize=(width, height), layout="constrained")
    with mpl.rc_context(STYLE):
        return made.subplots()


def make_folder(folder: Path) -> None:
    """Create a folder for diagrams, if necessary.

    Raises
    ------
    InputError
        If it cannot be made.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(
            f"folder: given {folder}, which cannot be made ({error.strerror}); allowed is one that can be "
            "written, because the diagrams go there."
        ) from None


def math_symbol(symbol: str) -> str:
    """Write a symbol such as L_shm for matplotlib's mathematics."""
    return (
        re.sub(r"^([A-Za-z]+)_(\w+)$", r"$\1_{\\mathrm{\2}}$", symbol)
        if "_" in symbol
        else f"${symbol}$"
    )


def with_gaps(values: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return values with NaN where they are unbounded, for a gap in their line."""
    return np.where(np.isfinite(values), values, np.nan)
