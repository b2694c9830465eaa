"""The HTML report: one file, pictures inside, that opens without a network."""

import base64
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from geometry.quantity import show_quantity

MEDIA_TYPES = {".png": "image/png", ".svg": "image/svg+xml"}


def write_report(results: Mapping[str, Any], pictures: Path, path: Path) -> Path:
    """Write the report of a run.

    Parameters
    ----------
    results : mapping
        Content of results.json.
    pictures : Path
        Folder of the pictures that the results name.
    path : Path
        The HTML file to write.

    Returns
    -------
    Path
        `path`.
    """
    from jinja2 import Environment, PackageLoader, StrictUndefined

    environment = Environment(
        loader=PackageLoader("crankfem"),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.filters |= {
        "nano": lambda value, digits=4: f"{value * 1e9:.{digits}g}",
        "sig": lambda value, digits=4: f"{value:.{digits}g}",
        "fixed": lambda value, digits=1: f"{value:.{digits}f}",
        # Round-off is shown as plain zero, without a sign.
        "clean": lambda value, digits: f"{round(value, digits) + 0.0:.{digits}f}",
        "percent": lambda value, digits=2: f"{value * 100.0:.{digits}g}",
        "mm": lambda value: show_quantity(value, "m"),
        "quantity": lambda value, unit: show_quantity(value, unit) if unit else f"{value:g}",
        "sentence": lambda text: f"{text[:1].upper()}{text[1:].removesuffix('.')}.",
        "words": lambda name: name.replace("_", " "),
        "signs": lambda text: text.replace(" * ", " · ").replace(" - ", " − "),
    }
    embedded = {name: _embed(pictures / file) for name, file in results["pictures"].items()}
    html = environment.get_template("report.html.j2").render(r=results, pictures=embedded)
    path.write_text(html, encoding="utf-8")
    return path


def _embed(picture: Path) -> str:
    content = base64.b64encode(picture.read_bytes()).decode()
    return f"data:{MEDIA_TYPES[picture.suffix]};base64,{content}"
