"""The HTML report of one throw: a page of its numbers and pictures that opens without a network."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from markupsafe import Markup

from crankfem.report.figures import load_figures
from crankfem.report.writing import STYLE, page_environment, plotting, template_text

TEMPLATE = "throw_report.html.j2"
# What is shown where it is there, by what it is called in reports.
VIEW, DRAWING = "throw_view.json", "throw_drawing.svg"


def render_throw_report(results: Mapping[str, Any], folder: Path) -> str:
    """Make the text of a throw's report.

    Parameters
    ----------
    results : mapping
        "about": provenance; "throw", as `throw_record` makes it; "formulas", as `formula_records`;
        "fillets", as `stress_record`, or None with "fillet_note".
    folder : Path
        Holds `VIEW` and `DRAWING`.

    Returns
    -------
    str
        A page of HTML.
    """
    figures, _ = load_figures(
        {"pictures": {"drawing": DRAWING}, "interactive": {"throw_view": VIEW}}, folder
    )
    shown = any(own.plot is not None for own in figures.values())
    return (
        page_environment()
        .get_template(TEMPLATE)
        .render(
            r=results,
            about=results["about"],
            figures=figures,
            style=Markup(template_text(STYLE)),
            scripts=plotting() if shown else (),
        )
    )
