"""Read a small CSV file of samples over crank angle: comments, a header of two names, rows."""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from crankbase.array_checks import FloatArray
from crankbase.errors import InputError, shortened
from crankbase.input_file import CSV, LARGEST_TABLE_FILE, GivenFile, InputFile
from dynamics.cycle import checked_strokes, cycle_degrees, first_not_increasing, mean_step

# Fewer samples show no cycle.
FEWEST_SAMPLES = 3


@dataclass(frozen=True)
class TableKind:
    """Contents of a table, and words for its messages.

    Parameters
    ----------
    angle_names, value_names : tuple of str
        Allowed names of the first and of the second column.
    headers : str
        The allowed headers in words.
    header_says : str
        What follows from the header alone.
    """

    name: str
    angle_names: tuple[str, ...]
    value_names: tuple[str, ...]
    headers: str
    header_says: str


@dataclass(frozen=True, eq=False)
class SampleRows:
    """A file as read.

    Parameters
    ----------
    angle_name, value_name : str
        The two names of the header.
    angles, values : ndarray of shape (m,)
        The two columns, in the units stated in their names; angles increase strictly.
    lines : tuple of int
        Line number of each row, counted from 1.
    comments : tuple of str
        The comment lines, without their number sign.
    """

    path: Path
    angle_name: str
    value_name: str
    angles: FloatArray
    values: FloatArray
    lines: tuple[int, ...]
    comments: tuple[str, ...]

    @property
    def source(self) -> str:
        """The comments as one text."""
        return "\n".join(self.comments)

    def angle_error(self, index: int, message: str) -> InputError:
        """Return the error for the angle of a row, with file and line."""
        return InputError(f"{self.path}, line {self.lines[index]}: {self.angle_name}: {message}.")

    def value_error(self, index: int, message: str) -> InputError:
        """Return the error for the value of a row, with file and line."""
        return InputError(f"{self.path}, line {self.lines[index]}: {self.value_name}: {message}.")

    def step_error(self, index: int, allowed: str) -> InputError:
        """Return the error for an angle [deg] that does not fit the one before it."""
        before, after = self.angles[index - 1 : index + 1]
        return self.angle_error(
            index, f"given {after:g} deg after {before:g} deg; allowed are {allowed}"
        )

    def strokes(
        self, cycles: Mapping[int, float], fits: Callable[[FloatArray, float], bool], also: str = ""
    ) -> int:
        """Return the strokes of the cycle that the angles cover.

        Parameters
        ----------
        cycles : mapping of int to float
            Length of the cycle [deg] for each number of strokes that is possible.
        """
        for strokes, cycle in cycles.items():
            if fits(self.angles, cycle):
                return strokes
        lengths = " or ".join(f"{cycle:g} deg" for cycle in cycles.values())
        raise self.angle_error(
            -1,
            f"given angles from {self.angles[0]:g} to {self.angles[-1]:g} deg in steps of "
            f"{mean_step(self.angles):g} deg; allowed is one cycle of {lengths}, with or without the closing "
            f"sample{also}, because what the table holds repeats with the cycle",
        )

    def check_closing(self, values: FloatArray, tolerance: float) -> None:
        """Refuse a closing sample that differs from the first by more than a share of the largest."""
        if abs(values[-1] - values[0]) > tolerance * np.max(np.abs(values)):
            raise self.value_error(
                -1,
                f"given {self.values[-1]:g} for the closing sample; allowed is the {self.values[0]:g} of "
                f"line {self.lines[0]}, because the closing sample repeats the first one cycle later",
            )


def possible_cycles(strokes: int | None) -> dict[int, float]:
    """Return the length of the cycle [deg] for the strokes given, or for both."""
    possible = (4, 2) if strokes is None else (checked_strokes(strokes),)
    return {number: cycle_degrees(number) for number in possible}


def read_sample_rows(path: GivenFile, kind: TableKind) -> SampleRows:
    """Read comment lines, header and rows of two numbers."""
    file = InputFile.of(path)
    path = file.path
    text = file.text(LARGEST_TABLE_FILE, f"a {kind.name}", f"a {kind.name} (CSV)", CSV)
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
            samples.append(_sample(path, number, stripped, names))
            lines.append(number)
    if not names[0]:
        raise InputError(
            f"{path}: no header; allowed is {kind.headers}, because it says {kind.header_says}."
        )
    if len(samples) < FEWEST_SAMPLES:
        raise InputError(
            f"{path}: given {len(samples)} samples; allowed are {FEWEST_SAMPLES} or more, over a whole "
            "cycle, because what the table holds repeats with it."
        )
    angles, values = np.array(samples, dtype=np.float64).T.copy()
    rows = SampleRows(path, *names, angles, values, tuple(lines), tuple(comments))
    index = first_not_increasing(angles)
    if index is not None:
        raise rows.step_error(
            index, "strictly increasing angles, because the samples follow the crank"
        )
    return rows


def _header(path: Path, number: int, line: str, kind: TableKind) -> tuple[str, str]:
    names = [name.strip() for name in line.split(",")]
    if len(names) != 2 or names[0] not in kind.angle_names or names[1] not in kind.value_names:
        raise InputError(
            f'{path}, line {number}: given the header "{shortened(line)}"; allowed is {kind.headers}, '
            f"because it says {kind.header_says}."
        )
    return names[0], names[1]


def _sample(path: Path, number: int, line: str, names: tuple[str, str]) -> tuple[float, float]:
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
                "because every sample counts."
            )
        values.append(value)
    return values[0], values[1]
