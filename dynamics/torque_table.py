"""Read the torque of one throw over a cycle from a small CSV file."""

from dataclasses import dataclass

import numpy as np

from crankbase.checks.arrays import FloatArray, read_only
from crankbase.input_file import GivenFile
from crankbase.library_types import Axes, DataFrame
from crankbase.summaries import summarized
from crankbase.tables.frames import table
from dynamics.cycle import covers_cycle, cycle_degrees, first_uneven, has_closing_sample
from dynamics.harmonics import Harmonics, harmonics
from dynamics.plots.harmonics import draw_samples
from dynamics.sample_table import TableKind, possible_cycles, read_sample_rows

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
    header_says="which angle is meant and in which units",
)


@summarized("torque [N m]", "crank_angle_deg [deg]", "strokes", "source")
@dataclass(frozen=True, eq=False)
class TorqueTable:
    """The torque of one throw, evenly sampled over one cycle, without the closing sample.

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

    def plot(self, axes: Axes | None = None) -> Axes:
        """Draw the samples, and the sum of their harmonics between them.

        Parameters
        ----------
        axes : matplotlib.axes.Axes, optional
            Where to draw; new axes by default.

        Returns
        -------
        matplotlib.axes.Axes
        """
        return draw_samples(axes, self.torque, self.harmonics(), title="Torque of one throw")

    def to_pandas(self) -> DataFrame:
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
        return table({"crank_angle": (self.crank_angle_deg, "deg"), "torque": (self.torque, "N m")})


def read_torque_table(path: GivenFile, *, strokes: int | None = None) -> TorqueTable:
    """Read a torque table.

    The file is CSV: comment lines that start with a number sign, the header
    ``crank_angle_deg,torque_Nm`` or ``cycle_angle_deg,torque_Nm``, then one sample a line. The
    crank angle [deg] covers 720 deg in a four-stroke and 360 deg in a two-stroke engine, the cycle
    angle [deg] 360 deg in either. A closing sample that repeats the first is dropped.

    Parameters
    ----------
    path : path
        The file.
    strokes : int, optional
        Strokes per cycle, 2 or 4. Crank angles determine it; for cycle angles it is 4
        by default.

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
    cycles = possible_cycles(strokes)
    rows = read_sample_rows(path, TABLE)
    index = first_uneven(rows.angles)
    if index is not None:
        usual = np.median(np.diff(rows.angles))
        raise rows.step_error(
            index, f"even steps (here {usual:g} deg), because the sums weigh all samples alike"
        )
    if rows.angle_name == CYCLE_ANGLE:
        cycles = {4 if strokes is None else strokes: 360.0}
    found = rows.strokes(
        cycles,
        lambda angles, cycle: covers_cycle(angles, cycle) or has_closing_sample(angles, cycle),
    )
    used = rows.angles.size
    if has_closing_sample(rows.angles, cycles[found]):
        rows.check_closing(rows.values, CLOSING_TOLERANCE)
        used -= 1
    return TorqueTable(
        crank_angle_deg=read_only(cycle_degrees(found) / cycles[found] * rows.angles[:used]),
        torque=read_only(rows.values[:used].copy()),
        source=rows.source,
        strokes=found,
    )
