"""Read the torque of one throw over a cycle from a small CSV file."""

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from crankbase.checks.arrays import FloatArray, read_only

from crankbase.drawing.diagram_style import new_axes
from crankbase.drawing.legends import write_title
from crankbase.errors import InputError
from crankbase.summaries import summarized
from crankbase.tables.frames import table
from dynamics.cycle import (
    checked_strokes,
    covers_cycle,
    cycle_degrees,
    first_uneven,
    has_closing_sample,
    mean_step,
)
from dynamics.harmonics import Harmonics, harmonics
from dynamics.plots.sampled_torque import draw_samples
from dynamics.sample_table import (
    SampleRows,
    TableKind,
    check_increasing,
    read_sample_rows,
    wrong_angle,
)

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from pandas import DataFrame

CYCLE_ANGLE = "cycle_angle_deg"
CRANK_ANGLE = "crank_angle_deg"
TORQUE = "torque_Nm"
# First and closing sample count as equal within this share of the largest torque.
CLOSING_TOLERANCE = 1e-9

TABLE = TableKind(
    name="torque table",
    angle_names=(CRANK_ANGLE, CYCLE_ANGLE),
    value_names=(TORQUE,),
    headers=f'"{CRANK_ANGLE},{TORQUE}" or "{CYCLE_ANGLE},{TORQUE}"',
    header_shows="it says the angle",
    header_reason="it says which angle is meant and in which units",
    sample_reason="every sample enters the sums",
)


@summarized("torque [N m]", "crank_angle_deg [deg]", "strokes", "source")
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

    def plot(self, axes: "Axes | None" = None) -> "Axes":
        """Draw the samples, and the sum of their harmonics between them.

        Parameters
        ----------
        axes : matplotlib.axes.Axes, optional
            Where to draw; those of a new figure if not given.

        Returns
        -------
        matplotlib.axes.Axes
        """
        axes = new_axes(axes)
        draw_samples(axes, self.torque, self.harmonics())
        write_title(axes, "Torque of one throw")
        return axes

    def to_pandas(self) -> "DataFrame":
        """Return crank angles and torques, a row for each sample.

        Returns
        -------
        pandas.DataFrame
            Units of the columns in ``attrs["units"]``.

        Raises
        ------
        MissingLibraryError
            If pandas is not installed.
        """
        return table(
            {
                "crank_angle": (np.radians(self.crank_angle_deg), "rad"),
                "torque": (self.torque, "N m"),
            }
        )


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
    rows = read_sample_rows(path, TABLE)
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
        torque=read_only(rows.values[:count].copy()),
        source="\n".join(rows.comments),
        strokes=strokes,
    )


def _check_even(path: Path, rows: SampleRows) -> None:
    check_increasing(path, rows)
    index = first_uneven(rows.angles)
    if index is not None:
        usual = np.median(np.diff(rows.angles))
        wanted = f"even steps (here {usual:g} deg), because the sums weigh all samples alike"
        raise wrong_angle(path, rows, index, wanted)


def _cycle_and_strokes(path: Path, rows: SampleRows, strokes: int | None) -> tuple[float, int]:
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


def _check_closing(path: Path, rows: SampleRows) -> None:
    first, last = rows.values[0], rows.values[-1]
    if abs(last - first) > CLOSING_TOLERANCE * np.max(np.abs(rows.values)):
        raise InputError(
            f"{path}, line {rows.lines[-1]}: {TORQUE}: given {last:g} N m for the closing sample; "
            f"allowed is the {first:g} N m of line {rows.lines[0]}, because the closing sample "
            "repeats the first one cycle later."
        )
