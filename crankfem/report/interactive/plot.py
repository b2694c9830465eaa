"""The plots of a run, each described once: what it is called, what it says, and what draws it."""

import json
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Generic, TypeVar

from crankbase.diagrams import Diagram, draw_diagram, figure, legend_below, make_folder
from crankbase.errors import InputError
from crankbase.frames import Axes
from crankbase.outputs import check_output, write_text
from crankfem.analyses.titles import add_title
from crankfem.report.interactive.style import HEIGHT, Figure, Part, diagram_figure


def write_figure(path: Path, traces: list[Part], layout: Part) -> Path:
    """Write a figure as small JSON in plotly's form.

    Parameters
    ----------
    path : Path
        Ends in .json.
    traces : list of dict
        plotly's "data".

    Returns
    -------
    Path
        The same.
    """
    # Numbers that JSON does not know are an error here: curves have gaps where there is no number.
    text = json.dumps(
        {"data": traces, "layout": layout},
        separators=(",", ":"),
        allow_nan=False,
        ensure_ascii=False,
    )
    try:
        write_text(path, text + "\n", "plot")
    except OSError as error:
        raise InputError(
            f"path: given {path}, which cannot be written ({error.strerror}); allowed is a file in an "
            "existing folder, because the figure goes there."
        ) from None
    return path


Run = TypeVar("Run")
LEGEND_COLUMNS = 4


@dataclass(frozen=True)
class Plot(Generic[Run]):
    """A diagram on paper, on a screen, or both.

    Attributes
    ----------
    name : str
        Of its files, but for their endings, and in results.json.
    alt, caption : str
        What a report says in its place, and below it.
    static : callable or None
        Draws it into a file from what it shows.
    interactive : callable or None
        Describes it to plotly.
    needs : str
        Of `Plots.has`, what must be there for it.
    """

    name: str
    alt: str
    caption: str
    static: Callable[[Path, Run], object] | None = None
    interactive: Callable[[Run], Figure] | None = None
    needs: str = ""

    def draw(self, folder: Path, run: Run) -> Path:
        """Draw it on paper."""
        assert self.static is not None
        path = folder / f"{self.name}.svg"
        self.static(path, run)
        return path

    def write(self, folder: Path, run: Run) -> Path:
        """Write it for a screen; errors as of `write_figure`."""
        assert self.interactive is not None
        return write_figure(folder / f"{self.name}.json", *self.interactive(run))


def plot_of_curves(
    name: str,
    alt: str,
    caption: str,
    describe: Callable[[Run], Diagram],
    title: Callable[[Run], str],
    needs: str = "",
    height: int = HEIGHT,
) -> Plot[Run]:
    """Return a plot whose curves are described once, for paper and for a screen, so high there [pixel]."""

    def draw(axes: Axes, run: Run) -> None:
        draw_diagram(axes, describe(run))
        legend_below(axes, LEGEND_COLUMNS)

    return Plot(
        name,
        alt,
        caption,
        picture(draw, title),
        lambda run: diagram_figure(describe(run), title(run), height),
        needs,
    )


def picture(
    draw: Callable[[Axes, Run], object], title: Callable[[Run], str], height: float = 4.2
) -> Callable[[Path, Run], None]:
    """Return what draws a picture of a run into a file, with a title above all."""

    def write(path: Path, run: Run) -> None:
        with figure(path, width=6.0, height=height) as axes:
            draw(axes, run)
            axes.set_title("", loc="left")
            add_title(axes, title(run))

    return write


@dataclass(frozen=True)
class Plots(Generic[Run]):
    """The plots of one thing; `has` tells what there is to show of it, by the names plots need."""

    plots: tuple[Plot[Run], ...]
    has: Callable[[Run], Iterable[str]] = lambda _: ()

    def of(self, run: Run) -> list[Plot[Run]]:
        """Return those for which everything is there."""
        return self.with_(self.has(run))

    def with_(self, there: Iterable[str]) -> list[Plot[Run]]:
        """Return those that need nothing but what is there."""
        known = {"", *there}
        return [plot for plot in self.plots if plot.needs in known]

    def files(self, there: Iterable[str] = ()) -> list[str]:
        """Return the names of the static ones' files, of those that need nothing but what is there."""
        return [f"{plot.name}.svg" for plot in self.with_(there) if plot.static is not None]

    def draw(self, folder: Path, run: Run) -> list[Path]:
        """Write the static ones into a folder, which is made if it is not there.

        Returns
        -------
        list of Path
            The SVG files.
        """
        make_folder(folder)
        for name in self.files(self.has(run)):
            check_output(folder / name, "picture")
        return [plot.draw(folder, run) for plot in self.of(run) if plot.static is not None]
