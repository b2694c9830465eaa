"""Read the gas force on a piston over a revolution from a small CSV file."""

import numpy as np

from crankbase.checks.arrays import FloatArray
from crankbase.input_file import GivenFile
from dynamics.gas.pressure import WIDEST_GAP, widest_gap
from dynamics.gas.pressure_table import CLOSING_TOLERANCE, closes_cycle, opens_little
from dynamics.hinge.crosshead import GasForce
from dynamics.hinge.periodic import TURN
from dynamics.sample_table import TableKind, read_sample_rows

CRANK_ANGLE = "crank_angle_deg"
UNITS = {"N": 1.0, "kN": 1e3, "MN": 1e6}
TURN_DEG = 360.0

TABLE = TableKind(
    name="gas force table",
    angle_names=(CRANK_ANGLE,),
    value_names=tuple(f"gas_force_{unit}" for unit in UNITS),
    headers=f'"{CRANK_ANGLE},gas_force_N", or "kN" or "MN" for "N"',
    header_says="in which unit the force is given",
)


def read_gas_force(path: GivenFile) -> GasForce:
    """Read a gas force table.

    The file is CSV: comment lines that start with a number sign, the header
    ``crank_angle_deg,gas_force_N`` (or ``kN``, ``MN``), then one sample a line. Angles count from the top
    dead center and cover a revolution, wherever it starts, in steps of up to 10 deg; the force is positive
    towards the shaft. A closing sample that repeats the first is dropped.

    Parameters
    ----------
    path : path

    Returns
    -------
    callable
        Force [N] at crank angles [rad] from the top: the periodic cubic spline through the
        samples.

    Raises
    ------
    InputError
        With file and, where there is one, line: if the file cannot be read, the header or a number is
        wrong, angles do not increase, do not cover one revolution or leave a gap wider than 10 deg, or the
        closing sample differs from the first by more than a thousandth of the largest force.
    """
    rows = read_sample_rows(path, TABLE)
    rows.strokes(
        {2: TURN_DEG},
        lambda angles, turn: closes_cycle(angles, turn) or opens_little(angles, turn),
        f" and open by {WIDEST_GAP:g} deg at most",
    )
    angles, force = rows.angles, rows.values * UNITS[rows.value_name.rpartition("_")[2]]
    if closes_cycle(angles, TURN_DEG):
        rows.check_closing(force, CLOSING_TOLERANCE)
        angles, force = angles[:-1], force[:-1]
    index, gap = widest_gap(angles, TURN_DEG)
    if index > 0 and gap > WIDEST_GAP * (1.0 + 1e-9):
        raise rows.step_error(
            index,
            f"gaps of {WIDEST_GAP:g} deg at most, because a wider one may hide the force's rise",
        )
    return _repeated(np.radians(angles), force)


def _repeated(angles: FloatArray, values: FloatArray) -> GasForce:
    from scipy.interpolate import CubicSpline  # here: loading it takes a quarter second

    closed = np.append(angles, angles[0] + TURN)
    curve = CubicSpline(closed, np.append(values, values[0]), bc_type="periodic")
    return lambda asked: np.asarray(curve(asked))
