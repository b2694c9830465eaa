"""The common style of all diagrams, and what several of them draw: curves over an axis, bars, legends."""

import math
import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal, NamedTuple, TypeAlias

import numpy as np
from numpy.typing import ArrayLike

from crankbase.array_checks import Array
from crankbase.errors import InputError, visible
from crankbase.frames import Axes
from crankbase.outputs import atomic_file, check_output
from crankbase.quantity import DISPLAY_UNITS

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


def new_axes(axes: Axes | None = None, *, width: float = 7.2, height: float = 4.2) -> Axes:
    """Return the axes to draw on: those given, or those of a new figure in the style of all diagrams.

    Parameters
    ----------
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


def with_gaps(values: Array) -> Array:
    """Return values with NaN where they are unbounded, for a gap in their line."""
    return np.where(np.isfinite(values), values, np.nan)


# Room for the ticks and the label of an axis above a legend [points].
BELOW_AXIS = 34.0
SIZE, TITLE_SIZE = 8, 11
LONG_TITLE = 60  # letters


def legend_below(axes: Axes, columns: int) -> None:
    """Put the legend below the axes, without changing their width."""
    from matplotlib.transforms import ScaledTranslation

    axes.legend(
        fontsize=SIZE,
        loc="upper center",
        bbox_to_anchor=(0.5, 0.0),
        bbox_transform=axes.transAxes
        + ScaledTranslation(0.0, -BELOW_AXIS / 72.0, axes.figure.dpi_scale_trans),
        ncols=columns,
        frameon=False,
    )


def legend_above(axes: Axes) -> None:
    """Put the legend above the curves, next to the title, if curves fill the axes."""
    axes.legend(fontsize=SIZE, ncols=3, loc="lower right", bbox_to_anchor=(1.0, 1.0), frameon=False)


def legend_inside(axes: Axes) -> None:
    """Put the legend where it covers least."""
    axes.legend(fontsize=SIZE, frameon=False)


def title_lines(title: str) -> list[str]:
    """Break a title that is too long for half a page behind a comma, where it has one.

    Examples
    --------
    >>> title_lines("8L 32/42 generating set, nominal torsional stress, cylinder 7 - cylinder 8")
    ['8L 32/42 generating set, nominal torsional stress,', 'cylinder 7 - cylinder 8']
    """
    if len(title) <= LONG_TITLE or ", " not in title[:LONG_TITLE]:
        return [title]
    place = title.rindex(", ", 0, LONG_TITLE)
    return [title[: place + 1], title[place + 2 :]]


def write_title(
    axes: Axes, title: str, size: float = TITLE_SIZE, *, mathematics: bool = False
) -> None:
    """Write a title over the left end of the axes, unchanged, or with math notation between ``$``."""
    shown = title if mathematics else plain_text("\n".join(title_lines(title)))
    axes.set_title(shown, fontsize=size, loc="left")


def plain_text(text: str) -> str:
    r"""Return a text without math notation for matplotlib, such as a name given by a user.

    Otherwise two ``$`` would begin and end math notation, and invalid notation between them ends the drawing;
    control characters, which no SVG may hold, are written as escapes.
    To be applied once, when the text is passed to matplotlib.

    Examples
    --------
    >>> plain_text("Type $A_{$ 5")
    'Type \\$A_{\\$ 5'
    """
    return visible(text).replace("$", r"\$")


def display_unit(unit: str) -> tuple[str, float]:
    """Return the display unit of an SI unit, as in labels, and that unit's size.

    Parameters
    ----------
    unit : str
        SI; "" for a pure number.

    Examples
    --------
    >>> display_unit("m")
    ('mm', 0.001)
    >>> display_unit("kg"), display_unit("")
    (('kg', 1.0), ('1', 1.0))
    """
    text, size = DISPLAY_UNITS.get(unit, (unit, 1.0))
    return text.replace("1e-9", r"$10^{-9}$") or "1", size


Role: TypeAlias = Literal["total", "plain sum", "limit", "order", "curve"]
Dash: TypeAlias = Literal["solid", "dash", "dot", "dashdot"]

ALL_ORDERS = "#1c2733"
# Red is that of limits.
ORDER_COLORS = (BLUE, ORANGE, GREEN, "#7a5ba6", "#2a9d9d", "#8c6d1f")
# A second round of colors has other dashes, so that each curve has a look of its own.
DASHES: tuple[Dash, ...] = ("solid", "dash", "dot", "dashdot")
LIMIT_DASHES: tuple[Dash, ...] = ("dash", "dashdot")
ON_PAPER = {"solid": "-", "dash": "--", "dot": ":", "dashdot": "-."}


class LineStyle(NamedTuple):
    """Color, dashes, and width of a line [points]."""

    color: str
    dash: Dash
    width: float


def order_line_style(number: int) -> LineStyle:
    """Return the line style of one of many curves, from 0."""
    rounds, place = divmod(number, len(ORDER_COLORS))
    return LineStyle(ORDER_COLORS[place], DASHES[rounds % len(DASHES)], 1.1)


@dataclass(frozen=True, eq=False)
class Series:
    """One curve.

    Attributes
    ----------
    name : str
        In the legend.
    values : (m,) array
        In the unit of the axis; NaN leaves a gap.
    role : {"total", "plain sum", "limit", "order", "curve"}
        Its role, which determines its style.
    number : int
        From 0 among those of its role.
    main : bool
        Others are left out on paper, and hidden at first on a screen.
    color, dash : str
        Of a curve that has a role nowhere else.
    """

    name: str
    values: Array
    role: Role = "curve"
    number: int = 0
    main: bool = True
    color: str = ""
    dash: Dash = "solid"

    @property
    def line_style(self) -> LineStyle:
        """Color, dashes and width."""
        if self.role == "total":
            return LineStyle(ALL_ORDERS, "solid", 2.0)
        if self.role == "plain sum":
            return LineStyle(GRAY, "dot", 1.1)
        if self.role == "limit":
            return LineStyle(RED, LIMIT_DASHES[self.number % len(LIMIT_DASHES)], 1.4)
        if self.role == "order":
            return order_line_style(self.number)
        return LineStyle(self.color or order_line_style(self.number).color, self.dash, 1.5)


class Band(NamedTuple):
    """A shaded range of the horizontal axis."""

    low: float
    high: float
    color: str
    name: str


class Dots(NamedTuple):
    """Single points, such as those of a table.

    Attributes
    ----------
    symbols : str
        Letters as of matplotlib, and "O" for an open circle: one for all, or one for each point.
    weights : sequence of n floats
        From 0 to 1; larger dots have larger ones. None: all have one size.
    hover : str
        What a screen tells of a point, as of `Line`.
    texts : sequence of n str
        For ``%{text}`` there.
    group, main, numbers
        As of `Line`.
    """

    x: ArrayLike
    y: ArrayLike
    name: str
    color: str
    symbols: str = "o"
    weights: Sequence[float] | None = None
    hover: str = ""
    texts: Sequence[str] = ()
    group: str = ""
    main: bool = True
    numbers: Sequence[Sequence[float]] = ()


class Mark(NamedTuple):
    """A vertical line at a position of the horizontal axis."""

    place: float
    name: str
    color: str = RED


class Line(NamedTuple):
    """A line through points of its own, in the units of the axes; NaN leaves a gap.

    Attributes
    ----------
    hover : str
        What a screen tells of a point, in plotly's template language. "": name and both values, of a curve
        over an ascending x, whose points that nobody would miss it leaves out.
    width, marker : float
        Of the line, and of a dot at each point [points].
    texts : sequence of n str
        Plain, for ``%{text}``.
    group : str
        A legend switches all of a group at once, and shows a name in it once.
    main : bool
        Others are left out on paper, and hidden at first on a screen.
    numbers : sequence of n sequences of floats
        For ``%{customdata[0]}`` and so on.
    """

    x: ArrayLike
    y: ArrayLike
    name: str
    color: str
    hover: str = ""
    width: float = 1.4
    dash: Dash = "solid"
    marker: float = 0.0
    texts: Sequence[str] = ()
    group: str = ""
    main: bool = True
    numbers: Sequence[Sequence[float]] = ()


class Note(NamedTuple):
    """A text at a point: in its middle, to its right, above it, or on a line that begins there."""

    text: str
    x: float
    y: float
    side: Literal["middle", "right", "above", "line"]
    color: str = "black"


class Shape(NamedTuple):
    """A filled rectangle or ellipse behind the lines, from its lower left to its upper right corner."""

    low: tuple[float, float]
    high: tuple[float, float]
    color: str
    round: bool = False


class Limits(NamedTuple):
    """An axis: its label with the unit in brackets, its ends (None: as far as there are curves), ticks.

    The ticks have names if the axis has no numbers, or a distance.
    """

    label: str
    ends: tuple[float, float | None] | None = None
    ticks: Mapping[float, str] | None = None
    step: float | None = None


@dataclass(frozen=True, eq=False)
class Diagram:
    """A diagram for paper and for a screen; its lines, dots, and shapes cover those before them.

    Attributes
    ----------
    bands, marks : sequence of Band, of Mark
        Of those of the same name the first is in the legend.
    level : bool
        Whether a line marks zero.
    equal : bool
        Whether both axes have one scale, with lines at zero of both.
    diagonal : (low, high) or None
        Ends of a line where both axes are equal.
    lines_named : bool
        Whether the legend on paper has the lines; that on a screen has all.
    """

    x: Limits
    y: Limits
    lines: Sequence[Line]
    dots: Sequence[Dots] = ()
    notes: Sequence[Note] = ()
    bands: Sequence[Band] = ()
    marks: Sequence[Mark] = ()
    shapes: Sequence[Shape] = ()
    level: bool = False
    equal: bool = False
    diagonal: tuple[float, float] | None = None
    lines_named: bool = True


def curve_diagram(
    x: Array,
    series: Iterable[Series],
    x_label: str,
    y_label: str,
    *,
    top: float | None = None,
    signed: bool = False,
    x_step: float | None = None,
    **more: Any,
) -> Diagram:
    """Describe curves over one axis.

    Orders come last, and behind them what is no main curve.

    Parameters
    ----------
    x : (m,) array
        In the unit of the axis, ascending.
    x_label, y_label : str
        With their units in brackets.
    top : float, optional
        Upper end of the vertical axis, which begins at zero; by default that of the curves.
    signed : bool
        Whether the vertical axis extends below zero, with a line at zero.
    x_step : float, optional
        Distance between the ticks of the horizontal axis.
    **more
        Dots, bands and marks, as of `Diagram`.
    """
    lines = []
    for curve in sorted(series, key=lambda curve: (not curve.main, curve.role == "order")):
        color, dash, width = curve.line_style
        lines.append(
            Line(x, curve.values, curve.name, color, width=width, dash=dash, main=curve.main)
        )
    ends = (float(x[0]), float(x[-1])) if len(x) > 1 else None
    return Diagram(
        Limits(x_label, ends, step=x_step),
        Limits(y_label, None if signed else (0.0, top)),
        lines,
        level=signed,
        **more,
    )


# Sizes of dots on paper [points]: of those without weights by symbol, and at weights 0 and 1.
DOT_SIZES = {"o": 4.5, "D": 4.5, "x": 7.0, "_": 22.0}
LEAST_DOT, DOT_GROWTH = 2.5, 9.0
# Letters that stand side by side under the axis.
TICK_ROOM = 90


def draw_diagram(axes: Axes, diagram: Diagram) -> None:
    """Draw a diagram on axes; the legend is left to the caller."""
    draw_bands(axes, (*diagram.bands, *diagram.marks))
    for shape in diagram.shapes:
        _draw_shape(axes, shape)
    if diagram.level or diagram.equal:
        axes.axhline(0.0, color=GRAY, linewidth=1.0)
    if diagram.equal:
        axes.axvline(0.0, color=GRAY, linewidth=1.0)
        axes.set_aspect("equal")
    if diagram.diagonal is not None:
        axes.plot(diagram.diagonal, diagram.diagonal, color=GRAY, linewidth=1.0)
    for curve in diagram.lines:
        if curve.main:
            axes.plot(
                curve.x,
                curve.y,
                color=curve.color,
                linestyle=ON_PAPER[curve.dash],
                linewidth=curve.width,
                marker="o" if curve.marker else "",
                markersize=curve.marker,
                label=curve.name if diagram.lines_named else None,
            )
    for note in diagram.notes:
        _draw_note(axes, note)
    for dots in diagram.dots:
        if dots.main:
            draw_dots(axes, dots)
    axes.set_xlabel(diagram.x.label)
    axes.set_ylabel(diagram.y.label)
    if diagram.x.ticks is not None:
        names = list(diagram.x.ticks.values())
        crowded = sum(max(map(len, name.split("\n"))) for name in names) > TICK_ROOM
        axes.set_xticks(
            list(diagram.x.ticks),
            [name.replace("\n", " ") for name in names] if crowded else names,
            fontsize=8,
            rotation=40 if crowded else 0,
            ha="right" if crowded else "center",
        )
    if diagram.x.ends is not None:
        axes.set_xlim(*diagram.x.ends)
    if step := diagram.x.step:
        first, last = axes.get_xlim()
        axes.set_xticks(np.arange(np.ceil(first / step) * step, last + 1e-6, step))
    if diagram.y.ends is not None:
        axes.set_ylim(*diagram.y.ends)


def _draw_shape(axes: Axes, shape: Shape) -> None:
    from matplotlib.patches import Ellipse, Rectangle

    low, width, height = shape.low, shape.high[0] - shape.low[0], shape.high[1] - shape.low[1]
    middle = (low[0] + 0.5 * width, low[1] + 0.5 * height)
    patch = Ellipse(middle, width, height) if shape.round else Rectangle(low, width, height)
    # Over the grid, under the lines.
    patch.set(facecolor=shape.color, edgecolor=GRAY, zorder=1.5)
    axes.add_patch(patch)


def draw_dots(axes: Axes, dots: Dots) -> None:
    """Draw single points; crosses and dashes have no name in the legend."""
    x, y = np.atleast_1d(dots.x), np.atleast_1d(dots.y)
    alike = dots.weights is None and len(dots.symbols) == 1
    symbols = dots.symbols * x.size if len(dots.symbols) == 1 else dots.symbols
    named = x.size > 0 and not set("x_") & set(symbols)
    edge: dict[str, Any] = {"markeredgecolor": "white", "markeredgewidth": 0.5}
    for place, symbol in enumerate(symbols[:1] if alike else symbols):
        size = DOT_SIZES.get(symbol, 4.0)
        if dots.weights is not None:
            size = LEAST_DOT + DOT_GROWTH * dots.weights[place]
        look: dict[str, Any] = {"color": dots.color, "markersize": size}
        if symbol == "O":
            symbol, look = "o", look | {"markerfacecolor": "none", "alpha": 0.45}
        elif symbol not in "x_":
            look |= edge
        those = slice(None) if alike else place
        label = dots.name if alike and named else None
        axes.plot(x[those], y[those], symbol, zorder=3, label=label, **look)
    if named and not alike:
        axes.plot([], [], "o", color=dots.color, label=dots.name)


def _draw_note(axes: Axes, note: Note) -> None:
    offset, across, up = {
        "middle": ((0, 0), "center", "center"),
        "right": ((3, 0), "left", "center"),
        "above": ((0, 2), "center", "bottom"),
        "line": ((4, 5), "left", "baseline"),
    }[note.side]
    # What it crosses does not run through it.
    ground = {"facecolor": "white", "alpha": 0.85, "edgecolor": "none", "pad": 0.8}
    axes.annotate(
        note.text,
        (note.x, note.y),
        xytext=offset,
        textcoords="offset points",
        fontsize=8 if note.side in ("middle", "line") else 7,
        color=note.color,
        ha=across,
        va=up,
        bbox=ground if note.side == "line" else None,
        annotation_clip=None if note.side == "line" else False,
    )


def bracketed(label: str) -> str:
    """Return the unit in brackets at the end of a label.

    Examples
    --------
    >>> bracketed("alternating stress [MPa]")
    'MPa'
    """
    return label.rpartition("[")[2].removesuffix("]")


def draw_bands(axes: Axes, bands: Iterable[Band | Mark]) -> None:
    """Shade ranges of the horizontal axis, and mark positions; of one name the first is in the legend."""
    named: set[str] = set()
    for band in bands:
        label = None if band.name in named else band.name
        named.add(band.name)
        if isinstance(band, Band):
            axes.axvspan(band.low, band.high, color=band.color, zorder=0, label=label)
        else:
            axes.axvline(band.place, color=band.color, linewidth=0.8, linestyle=":", label=label)


FILLED = 0.8  # share of the distance of two groups that their bars take
ROOM = 70  # letters that stand side by side under the axis
PALE = "#c9d2db"


def draw_groups(
    axes: Axes, names: Sequence[str], series: Mapping[str, ArrayLike], label: str
) -> None:
    """Draw upright bars in groups.

    Parameters
    ----------
    names : sequence of n str
        Of the groups, under the axis.
    series : mapping of str to (n,) array_like
        Values by kind, in the unit of the axis; one bar of each kind in every group.
    label : str
        Label of the vertical axis, with its unit.
    """
    places, width = np.arange(len(names)), FILLED / len(series)
    for number, (kind, values) in enumerate(series.items()):
        shift = (number - 0.5 * (len(series) - 1)) * width
        color = COLORS[number % len(COLORS)]
        axes.bar(places + shift, np.asarray(values), width=width, color=color, label=kind)
    crowded = sum(map(len, names)) > ROOM
    axes.set_xticks(
        places,
        list(names),
        fontsize=8,
        rotation=30 if crowded else 0,
        ha="right" if crowded else "center",
    )
    axes.axhline(0.0, color=GRAY, linewidth=0.8)
    axes.grid(axis="x", visible=False)
    axes.set_ylabel(label)
    if len(series) > 1:
        axes.legend(frameon=False, fontsize=8, loc="upper left", bbox_to_anchor=(1.0, 1.0))


def draw_rows(
    axes: Axes,
    names: Sequence[str],
    values: ArrayLike,
    label: str,
    *,
    colors: Sequence[str] | str = COLORS[0],
    texts: Sequence[str] | None = None,
) -> None:
    """Draw horizontal bars from the top down, each with its value.

    Parameters
    ----------
    values : (n,) array_like
        In the unit of the axis.
    label : str
        Label of the horizontal axis, with its unit.
    texts : sequence of n str, optional
        Written at the bars' ends; the values to three digits by default.
    """
    sizes, places = np.asarray(values, dtype=float), np.arange(len(names))
    axes.barh(places, sizes, color=colors)
    for place, size in enumerate(sizes.tolist()):
        axes.annotate(
            f"{size:.3g}" if texts is None else texts[place],
            (size, place),
            xytext=(4 if size >= 0.0 else -4, 0),
            textcoords="offset points",
            va="center",
            ha="left" if size >= 0.0 else "right",
            fontsize=8,
        )
    axes.set_yticks(places, list(names), fontsize=8)
    axes.invert_yaxis()
    axes.margins(x=0.15)
    axes.grid(axis="y", visible=False)
    axes.set_xlabel(label)


def draw_matrix(axes: Axes, values: ArrayLike, rows: Sequence[str], columns: Sequence[str]) -> None:
    """Draw a table of numbers, each cell colored by its value, blue below zero and orange above.

    Parameters
    ----------
    values : (n, m) array_like
        In the unit stated in the title.
    """
    from matplotlib.colors import LinearSegmentedColormap

    numbers = np.asarray(values, dtype=float)
    largest = float(np.max(np.abs(numbers))) or 1.0
    decimals = max(0, 2 - math.floor(math.log10(largest)))
    colors = LinearSegmentedColormap.from_list("signed", ("#7fa8cf", "white", "#eab676"))
    axes.imshow(numbers, cmap=colors, vmin=-largest, vmax=largest, aspect="auto")
    for row, column in np.ndindex(numbers.shape):
        text = f"{round(float(numbers[row, column]), decimals) + 0.0:.{decimals}f}"
        axes.text(column, row, text, ha="center", va="center", fontsize=8)
    axes.set_xticks(range(len(columns)), list(columns), fontsize=8)
    axes.set_yticks(range(len(rows)), list(rows), fontsize=8)
    axes.grid(visible=False)
