"""What moves in each kind of vibration, and the units in which its amplitudes are read."""

from typing import Literal, NamedTuple

from crankbase.units.units import UNITS, VIBRATING, unit_symbol


class Motion(NamedTuple):
    """Motion of a node in one kind of vibration.

    Attributes
    ----------
    quantity : str
        What diagrams call it.
    si : str
        Its unit in records.
    printed : str
        Its unit among those of `crankbase.tables.output_units`.
    unit : str
        The same as diagrams and reports write it.
    size : float
        Of that unit, in SI.
    """

    quantity: Literal["displacement", "twist"]
    si: str
    printed: str
    unit: str
    size: float


def _motion(quantity: Literal["displacement", "twist"]) -> Motion:
    printed = VIBRATING[quantity]
    si, size = UNITS[printed]
    return Motion(quantity, si, printed, unit_symbol(printed), size)


MOTION = {"axial": _motion("displacement"), "torsional": _motion("twist")}
