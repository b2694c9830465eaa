"""Read the torque of one throw over a cycle from a small CSV file."""

import math
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from dynamics.checks import FloatArray, read_only
from dynamics.cycle import (
    checked_strokes,
    covers_cycle,
    cycle_degrees,
    first_not_increasing,
    first_uneven,
    has_closing_sample,
    mean_step,
)
from dynamics.harmonics import Harmonics, harmonics
from geometry.errors import InputError

CYCLE_ANGLE = "cycle_angle_deg"
CRANK_ANGLE = "crank_angle_deg"
TORQUE = "torque_Nm"
# First and closing sample count as equal within this share of the largest torque.
CLOSING_TOLERANCE = 1e-9


@dataclass(frozen=True, eq=False)
class TorqueTable:
    """The torque of one throw, evenly sampled over one cycle, closing sample left out.

    Parameters
    ----------
    crank_angle_deg : ndarray of shape (m,)
        Crank angle of the samples [deg].
    torque : ndarray of shape (m,)
        Torque [N m].
    source : str
        The comment lines of the file, without their number sign.
    strokes : int
        Strokes per cycle, 2 or 4.
    """

    crank_angle_deg: FloatArray
    torque: FloatArray
    source: str
    strokes: int

    def harmonics(self) -> Harmonics:
        """Return the harmonics of the torque [N m]."""
        return harmonics(self.torque, self.strokes, angles_deg=self.crank_angle_deg)


@dataclass(frozen=True)
class _Rows:
    """The file as read: header name of the angle, angles, torques and their line numbers."""

    angle_name: str
    angles: FloatArray
    torques: FloatArray
    lines: tuple[int, ...]
    comments: tuple[str, ...]


def read_torque_table(path: str | Path, *, strokes: int | None = None) -> TorqueTable:
    """Read a torque table.

    The file is CSV: comment lines that start with a number sign, the header
    ``crank_angle_deg,torque_Nm`` or ``cycle_angle_deg,torque_Nm``, then one sample a line. The
    crank angle [deg] covers 720 deg in a four-stroke and 360 deg in a two-stroke engine, the cycle
    angle [deg] 360 deg in either. A closing sample that repeats the first is dropped.

    Parameters
    ----------
    path : str or Path
        The file.
    strokes : int, optional
        Strokes per cycle, 2 or 4. Crank angles show it by themselves; for cycle angles it is 4
        unless given.

    Returns
    -------
    TorqueTable
        Crank angles [deg], torques [N m], source and strokes.

    Raises
    ------
    InputError
        With file and line, if the file cannot be read, the header or a number is wrong, the angles
        are not evenly spaced over one cycle, or the closing sample differs from the first.
    """
    path = Path(path)
    if strokes is not None:
        checked_strokes(strokes)
    rows = _read_rows(path)
    if rows.angles.size < 3:
        raise InputError(
            f"{path}: given {rows.angles.size} samples; allowed are 3 or more, because fewer do "
            "not show a harmonic."
        )
    _check_even(path, rows)
    cycle, strokes = _cycle_and_strokes(path, rows, strokes)
    count = rows.angles.size
    if has_closing_sample(rows.angles, cycle):
        _check_closing(path, rows)
        count -= 1
    scale = cycle_degrees(strokes) / cycle
    return TorqueTable(
        crank_angle_deg=read_only(scale * rows.angles[:count]),
        torque=read_only(rows.torques[:count].copy()),
        source="\n".join(rows.comments),
        strokes=strokes,
    )


def _read_rows(path: Path) -> _Rows:
    try:
        text = path.read_text(encoding="utf-8-sig")
    except (OSError, UnicodeDecodeError) as error:
        reason = getattr(error, "strerror", None) or "it is not UTF-8 text"
        raise InputError(f"{path}: the torque table cannot be read, because {reason}.") from None
    angle_name = ""
    comments: list[str] = []
    lines: list[int] = []
    samples: list[tuple[float, float]] = []
    for number, line in enumerate(text.splitlines(), start=1):
        stripped = line.strip()
        if stripped.startswith("#"):
            comments.append(stripped.lstrip("#").strip())
        elif stripped and not angle_name:
            angle_name = _header(path, number, stripped)
        elif stripped:
            samples.append(_sample(path, number, stripped, angle_name))
            lines.append(number)
    if not angle_name:
        raise InputError(f"{path}: no header; allowed is {_headers()}, because it says the angle.")
    table = np.array(samples, dtype=np.float64).reshape(-1, 2)
    return _Rows(angle_name, table[:, 0], table[:, 1], tuple(lines), tuple(comments))


def _headers() -> str:
    return f'"{CRANK_ANGLE},{TORQUE}" or "{CYCLE_ANGLE},{TORQUE}"'


def _header(path: Path, number: int, line: str) -> str:
    names = [name.strip() for name in line.split(",")]
    if len(names) != 2 or names[0] not in (CRANK_ANGLE, CYCLE_ANGLE) or names[1] != TORQUE:
        raise InputError(
            f'{path}, line {number}: given the header "{line}"; allowed is {_headers()}, because '
            "it says which angle is meant and in which units."
        )
    return names[0]


def _sample(path: Path, number: int, line: str, angle_name: str) -> tuple[float, float]:
    cells = [cell.strip() for cell in line.split(",")]
    if len(cells) != 2:
        raise InputError(
            f'{path}, line {number}: given "{line}"; allowed are two numbers with a comma between '
            f"them and decimal points, because the header is {angle_name},{TORQUE}."
        )
    values: list[float] = []
    for name, cell in zip((angle_name, TORQUE), cells, strict=True):
        try:
            value = float(cell)
        except ValueError:
            value = math.nan
        if not math.isfinite(value):
            raise InputError(
                f'{path}, line {number}: {name}: given "{cell}"; allowed are finite numbers, '
                "because every sample enters the sums."
            )
        values.append(value)
    return values[0], values[1]


def _check_even(path: Path, rows: _Rows) -> None:
    index = first_not_increasing(rows.angles)
    wanted = "strictly increasing angles, because the samples follow the crank"
    if index is None:
        index = first_uneven(rows.angles)
        usual = np.median(np.diff(rows.angles))
        wanted = f"even steps (here {usual:g} deg), because the sums weigh all samples alike"
    if index is not None:
        raise InputError(
            f"{path}, line {rows.lines[index]}: {rows.angle_name}: given {rows.angles[index]:g} "
            f"deg after {rows.angles[index - 1]:g} deg; allowed are {wanted}."
        )


def _cycle_and_strokes(path: Path, rows: _Rows, strokes: int | None) -> tuple[float, int]:
    """Return the cycle's length in the table's own angle [deg], and the strokes."""
    if rows.angle_name == CYCLE_ANGLE:
        possible = {4 if strokes is None else strokes: 360.0}
    else:
        possible = {number: cycle_degrees(number) for number in (4, 2)}
        if strokes is not None:
            possible = {strokes: possible[strokes]}
    for number, cycle in possible.items():
        if covers_cycle(rows.angles, cycle) or has_closing_sample(rows.angles, cycle):
            return cycle, number
    lengths = " or ".join(f"{cycle:g} deg" for cycle in possible.values())
    raise InputError(
        f"{path}, line {rows.lines[-1]}: {rows.angle_name}: given angles from {rows.angles[0]:g} "
        f"to {rows.angles[-1]:g} deg in steps of {mean_step(rows.angles):g} deg; allowed is one "
        f"cycle of {lengths}, with or without the closing sample, because harmonics are those of "
        "a whole cycle."
    )


def _check_closing(path: Path, rows: _Rows) -> None:
    first, last = rows.torques[0], rows.torques[-1]
    if abs(last - first) > CLOSING_TOLERANCE * np.max(np.abs(rows.torques)):
        raise InputError(
            f"{path}, line {rows.lines[-1]}: {TORQUE}: given {last:g} N m for the closing sample; "
            f"allowed is the {first:g} N m of line {rows.lines[0]}, because the closing sample "
            "repeats the first one cycle later."
        )
