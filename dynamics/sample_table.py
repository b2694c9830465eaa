"""Read a small CSV file of samples over crank angle: comments, a header of two names, rows."""

import math
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from crankbase.checks.arrays import FloatArray

from crankbase.errors import InputError, shortened
from crankbase.text_limits import LARGEST_TABLE_FILE, check_file_size
from dynamics.cycle import first_not_increasing


@dataclass(frozen=True)
class TableKind:
    """What a table holds, and what its messages say.

    Parameters
    ----------
    name : str
        What the file is called, such as "torque table".
    angle_names, value_names : tuple of str
        Allowed names of the first and of the second column.
    headers : str
        The allowed headers in words.
    header_shows : str
        Why a table cannot do without its header.
    header_reason : str
        Why no other header will do.
    sample_reason : str
        Why every sample must be a finite number.
    """

    name: str
    angle_names: tuple[str, ...]
    value_names: tuple[str, ...]
    headers: str
    header_shows: str
    header_reason: str
    sample_reason: str


@dataclass(frozen=True, eq=False)
class SampleRows:
    """A file as read.

    Parameters
    ----------
    angle_name, value_name : str
        The two names of the header.
    angles, values : ndarray of shape (m,)
        The two columns, in the units that their names state.
    lines : tuple of int
        Line number of each row, counted from 1.
    comments : tuple of str
        The comment lines, without their number sign.
    """

    angle_name: str
    value_name: str
    angles: FloatArray
    values: FloatArray
    lines: tuple[int, ...]
    comments: tuple[str, ...]


def read_sample_rows(path: Path, kind: TableKind) -> SampleRows:
    """Read comment lines, header and rows of two numbers.

    Parameters
    ----------
    path : Path
        The file: UTF-8 text with commas between cells and decimal points.
    kind : TableKind
        The allowed headers, and the words for messages.

    Returns
    -------
    SampleRows
        The columns as they stand; neither their order nor their range is checked.

    Raises
    ------
    InputError
        With file and line, if the file cannot be read, or the header or a number is wrong.
    """
    check_file_size(path, LARGEST_TABLE_FILE, f"a {kind.name}")
    try:
        text = path.read_text(encoding="utf-8-sig")
    except (OSError, UnicodeDecodeError) as error:
        reason = getattr(error, "strerror", None) or "it is not UTF-8 text"
        raise InputError(f"{path}: the {kind.name} cannot be read, because {reason}.") from None
    names = ("", "")
    comments: list[str] = []
    lines: list[int] = []
    samples: list[tuple[float, float]] = []
    for number, line in enumerate(text.splitlines(), start=1):
        stripped = line.strip()
        if stripped.startswith("#"):
            comments.append(stripped.lstrip("#").strip())
        elif stripped and not names[0]:
            names = _header(path, number, stripped, kind)
        elif stripped:
            samples.append(_sample(path, number, stripped, names, kind))
            lines.append(number)
    if not names[0]:
        raise InputError(
            f"{path}: no header; allowed is {kind.headers}, because {kind.header_shows}."
        )
    table = np.array(samples, dtype=np.float64).reshape(-1, 2)
    return SampleRows(*names, table[:, 0], table[:, 1], tuple(lines), tuple(comments))


def check_increasing(path: Path, rows: SampleRows) -> None:
    """Refuse angles that do not increase strictly.

    Raises
    ------
    InputError
        With file and line of the first angle that is not above the one before it.
    """
    index = first_not_increasing(rows.angles)
    if index is not None:
        raise wrong_angle(
            path,
            rows,
            index,
            "strictly increasing angles, because the samples follow the crank",
        )


def wrong_angle(path: Path, rows: SampleRows, index: int, wanted: str) -> InputError:
    """Return the error for an angle that does not fit the one before it.

    Parameters
    ----------
    path : Path
        The file.
    rows : SampleRows
        Its rows, angles in degrees.
    index : int
        Which row, from 1.
    wanted : str
        What is allowed and why.
    """
    return InputError(
        f"{path}, line {rows.lines[index]}: {rows.angle_name}: given {rows.angles[index]:g} "
        f"deg after {rows.angles[index - 1]:g} deg; allowed are {wanted}."
    )


def _header(path: Path, number: int, line: str, kind: TableKind) -> tuple[str, str]:
    names = [name.strip() for name in line.split(",")]
    if len(names) != 2 or names[0] not in kind.angle_names or names[1] not in kind.value_names:
        raise InputError(
            f'{path}, line {number}: given the header "{shortened(line)}"; allowed is {kind.headers}, '
            f"because {kind.header_reason}."
        )
    return names[0], names[1]


def _sample(
    path: Path, number: int, line: str, names: tuple[str, str], kind: TableKind
) -> tuple[float, float]:
    cells = [cell.strip() for cell in line.split(",")]
    if len(cells) != 2:
        raise InputError(
            f'{path}, line {number}: given "{shortened(line)}"; allowed are two numbers with a comma between '
            f"them and decimal points, because the header is {names[0]},{names[1]}."
        )
    values: list[float] = []
    for name, cell in zip(names, cells, strict=True):
        try:
            value = float(cell)
        except ValueError:
            value = math.nan
        if not math.isfinite(value):
            raise InputError(
                f'{path}, line {number}: {name}: given "{shortened(cell)}"; allowed are finite numbers, '
                f"because {kind.sample_reason}."
            )
        values.append(value)
    return values[0], values[1]
