"""The class document as one page of HTML that prints to A4."""

import base64
from collections.abc import Mapping, Sequence
from pathlib import Path

from markupsafe import Markup

from crankfem.analyses.provenance import program_version
from crankfem.analyses.submission.document import DocumentPart
from crankfem.analyses.vibration.run import EngineVibration
from crankfem.report.engine_schematic import engine_schematic
from crankfem.report.writing import page_environment, template_text

TEMPLATE, STYLES = "class.html.j2", ("report/style.css", "class.css")


def render_class_document(
    run: EngineVibration, parts: Sequence[DocumentPart], pictures: Mapping[str, Path], created: str
) -> str:
    """Return the text of the document.

    Parameters
    ----------
    pictures : mapping
        Name of each diagram that was drawn to its file, an SVG.
    created : str
        When, in words.
    """
    file, engine = run.engine_file, run.engine_file.engine
    return (
        page_environment()
        .get_template(TEMPLATE)
        .render(
            engine=engine,
            file=file.path.name,
            parts=parts,
            pictures={
                name: f"data:image/svg+xml;base64,{base64.b64encode(path.read_bytes()).decode()}"
                for name, path in pictures.items()
            },
            schematic=engine_schematic(
                engine.crank_angles, engine.top_order, run.torsional, engine.driven_by
            ),
            sources=file.sources,
            created=created,
            version=program_version(),
            style=Markup("\n".join(template_text(name) for name in STYLES)),
        )
    )
