"""The figures of a report: static pictures and, where there are some, interactive plots beside them."""

import base64
import re
import struct
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from markupsafe import Markup

MEDIA_TYPES = {".png": "image/png", ".svg": "image/svg+xml"}
POINT = 96.0 / 72.0  # [pixel]
VIEW_BOX = re.compile(rb'viewBox="\s*\S+\s+\S+\s+(\S+)\s+(\S+?)\s*"')


@dataclass(frozen=True)
class Figure:
    """A picture, an interactive plot, or both.

    Attributes
    ----------
    source : str or None
        The static picture as a data address.
    width, height : int
        Of the static picture [pixel].
    plot : Markup or None
        The interactive plot as JSON that may stand in a script element.
    """

    source: str | None = None
    width: int = 0
    height: int = 0
    plot: Markup | None = None


def load_figures(results: Mapping[str, Any], folder: Path) -> dict[str, Figure]:
    """Read all figures that results name.

    Parameters
    ----------
    results : mapping
        Content of results.json: "pictures" and, in newer ones, "interactive".
    folder : Path
        Where the files are.

    Returns
    -------
    dict
        Name to figure.

    Raises
    ------
    OSError
        If a file is missing.
    """
    pictures, plots = results["pictures"], results.get("interactive", {})
    found = {}
    for name in (*pictures, *(name for name in plots if name not in pictures)):
        source, width, height = None, 0, 0
        if name in pictures:
            source, width, height = _picture(folder / pictures[name])
        plot = script_text((folder / plots[name]).read_text("utf-8")) if name in plots else None
        found[name] = Figure(source, width, height, plot)
    return found


def script_text(text: str) -> Markup:
    """Return JSON that may stand in a script element: nothing in it can end or open one."""
    return Markup(text.strip().replace("<", "\\u003c"))


def _picture(path: Path) -> tuple[str, int, int]:
    content = path.read_bytes()
    width, height = _size(content, path.suffix)
    text = base64.b64encode(content).decode()
    return f"data:{MEDIA_TYPES[path.suffix]};base64,{text}", width, height


def _size(content: bytes, suffix: str) -> tuple[int, int]:
    """Width and height of a picture [pixel]; 0 where it does not say."""
    if suffix == ".png":
        width, height = struct.unpack(">II", content[16:24])
        return int(width), int(height)
    found = VIEW_BOX.search(content)
    if found is None:
        return 0, 0
    return round(float(found[1]) * POINT), round(float(found[2]) * POINT)
