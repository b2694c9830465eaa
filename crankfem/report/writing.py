"""The HTML reports: pages of numbers and pictures that open without a network."""

import re
from collections.abc import Mapping
from functools import cache, partial
from importlib.resources import files
from pathlib import Path
from typing import TYPE_CHECKING, Any

from markupsafe import Markup

from crankbase.outputs import recording_run_files, write_text
from crankfem.analyses.findings import reached_and_permitted
from crankfem.analyses.mechanism.torque_harmonics import harmonics_table
from crankfem.analyses.run_results import RunResults
from crankfem.analyses.strength.cycle_fatigue import fatigue_table
from crankfem.analyses.strength.engine_strength import factor_table, strength_table, torque_table
from crankfem.analyses.throw.formula_records import Formulas, compared_compliances
from crankfem.analyses.throw.stress import StressResults
from crankfem.analyses.throw.throw_record import ThrowResults
from crankfem.analyses.vibration.tables import (
    element_table,
    limit_table,
    met_while_running,
    misfiring_table,
    speed_table,
    whole_critical_table,
    whole_table,
)
from crankfem.files.engine.mechanism_cylinders import order_named
from crankfem.report.engine_schematic import engine_schematic
from crankfem.report.figures import PLOTS, Figure, load_figures, packed
from crankfem.report.summary import summary
from crankfem.report.text_filters import FILTERS, TABLE_DIGITS, printed, source_label
from dynamics import wording

if TYPE_CHECKING:
    from jinja2 import Environment


# Not allowed in HTML, even in scripts.
CONTROL = re.compile(r"[\x00-\x08\x0b\x0c\x0e-\x1f\x7f]")
# What makes tables, or their cells, of the results.
TABLES = (
    element_table,
    limit_table,
    met_while_running,
    misfiring_table,
    speed_table,
    whole_critical_table,
    whole_table,
    harmonics_table,
    strength_table,
    fatigue_table,
    factor_table,
    torque_table,
    reached_and_permitted,
)
TEMPLATE, STYLE, DRAWING = "report.html.j2", "report/style.css", "interactive.js"


def write_report(results: RunResults, pictures: Path, path: Path) -> Path:
    """Write the report of a run in one step; see `render_report`.

    Returns
    -------
    Path
        `path`.
    """
    return write_report_text(path, render_report(results, pictures)[0])


def write_report_text(path: Path, text: str) -> Path:
    """Write the report of a run in one step; errors as of `crankbase.outputs.write_text`."""
    with recording_run_files():
        return write_text(path, text, "report")


def render_report(results: RunResults, pictures: Path) -> tuple[str, str | None]:
    """Make the text of a run's report.

    Parameters
    ----------
    pictures : Path
        Folder of the pictures and plots that the results name.

    Returns
    -------
    text : str
        A page of HTML.
    note : str or None
        A sentence that names the pictures that cannot be read; the page does without them, and says
        the same.
    """
    figures, unread = load_figures(results.pictures, results.interactive, pictures)
    vibration = results.vibration
    note = f"Left out, because they cannot be read: {', '.join(unread)}." if unread else None
    html = (
        page_environment()
        .get_template(TEMPLATE)
        .render(
            r=results,
            first=summary(results),
            schematic=engine_schematic(
                results.engine.crank_angles,
                results.engine.firing_order,
                vibration.torsional,
                results.engine.driven_by,
            ),
            compliances=compared_compliances(
                results.throw,
                results.formulas,
                {chain.kind: chain.sources for chain in (vibration.axial, vibration.torsional)},
            ),
            further={
                name: compared_compliances(further.throw, further.formulas)
                for name, further in [*(results.throws or {}).items()][1:]
            },
            figures=figures,
            picture_notes=[text for text in (results.picture_note, note) if text],
            style=Markup(template_text(STYLE)),
            **scripts(figures),
        )
    )
    return html, note


@cache
def page_environment(most: int | None = TABLE_DIGITS) -> "Environment":
    """Return what renders the templates of pages, with so many digits of values in texts at most."""
    from jinja2 import Environment, PackageLoader, StrictUndefined

    environment = Environment(
        loader=PackageLoader("crankfem.report"),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
        finalize=partial(printed, most=most),
    )
    environment.filters |= FILTERS | {make.__name__: make for make in TABLES}
    environment.globals |= {"source_words": source_label, "wording": wording}
    environment.globals["order_named"] = order_named
    environment.filters["plot"] = PLOTS.__getitem__
    return environment


@cache
def _library() -> str:
    from plotly.offline import get_plotlyjs

    return packed(get_plotlyjs())


def scripts(figures: Mapping[str, Figure]) -> dict[str, str]:
    """Return what figures need of a page: the `library` that draws, packed, and the script `drawing`."""
    plots = any(drawn.plot is not None for drawn in figures.values())
    return {
        "library": _library() if plots else "",
        "drawing": Markup(script(template_text(DRAWING))) if figures else "",
    }


def script(text: str) -> str:
    """Write a script so that it may stand in a page: no control characters, nothing that ends it.

    Both stand in strings only, where their escapes mean the same.
    """
    shown = CONTROL.sub(lambda match: f"\\x{ord(match[0]):02x}", text)
    return shown.replace("</script", "<\\/script").replace("<!--", "<\\!--")


def template_text(name: str) -> str:
    """Return the text of a template, style or script."""
    return (files("crankfem.report") / "templates" / name).read_text(encoding="utf-8")


THROW_TEMPLATE = "throw_report.html.j2"
# What is shown where it is there, by what it is called in reports.
THROW_VIEW, THROW_DRAWING = "throw_view.json", "throw_drawing.svg"


def render_throw_report(results: dict[str, Any], folder: Path) -> str:
    """Make the text of a throw's report.

    Parameters
    ----------
    results : dict
        "about": provenance; "throw": `ThrowResults` "formulas": `Formulas` and "fillets":
        `StressResults` or None with "fillet_note", or their records.
    folder : Path
        Holds `THROW_VIEW` and `THROW_DRAWING`.

    Returns
    -------
    str
        A page of HTML.
    """
    fillets = results["fillets"]
    figures, _ = load_figures({"drawing": THROW_DRAWING}, {"throw_view": THROW_VIEW}, folder)
    return (
        page_environment()
        .get_template(THROW_TEMPLATE)
        .render(
            r=results
            | {
                "throw": ThrowResults.from_record(results["throw"]),
                "formulas": Formulas.from_record(results["formulas"]),
                "fillets": None if fillets is None else StressResults.from_record(fillets),
            },
            about=results["about"],
            figures=figures,
            style=Markup(template_text(STYLE)),
            **scripts(figures),
        )
    )
