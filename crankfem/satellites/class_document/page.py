"""The class document as one page of HTML that prints to A4."""

import base64
from collections.abc import Mapping, Sequence
from importlib.resources import files
from pathlib import Path

from markupsafe import Markup

from crankfem.analyses.provenance import program_version
from crankfem.analyses.vibration.run import EngineVibration
from crankfem.report.engine_schematic import engine_schematic
from crankfem.report.writing import STYLE, page_environment, template_text
from crankfem.satellites.class_document.document import DocumentPart

TEMPLATES = files("crankfem.satellites.class_document") / "templates"


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
    own_style = (TEMPLATES / "class.css").read_text(encoding="utf-8")
    return (
        page_environment(None)
        .from_string((TEMPLATES / "class.html.j2").read_text(encoding="utf-8"))
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
            style=Markup(f"{template_text(STYLE)}\n{own_style}"),
        )
    )
