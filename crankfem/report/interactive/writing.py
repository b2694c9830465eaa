"""From an interactive figure to its file."""

import json
from pathlib import Path

from crankbase.errors import InputError
from crankbase.outputs import write_text
from crankfem.report.interactive.style import Part


def write_figure(path: Path, traces: list[Part], layout: Part) -> Path:
    """Write a figure as small JSON in plotly's form.

    Parameters
    ----------
    path : Path
        Ends in .json.
    traces : list of dict
        plotly's "data".
    layout : dict

    Returns
    -------
    Path
        The same.

    Raises
    ------
    InputError
        If the file cannot be written.
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
