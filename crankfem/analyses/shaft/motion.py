"""Motion in each kind of vibration, and the display units of its amplitudes."""

from typing import Literal, NamedTuple

from crankbase.units.number_formats import significant
from crankbase.units.units import UNITS, VIBRATING, unit_symbol


class Motion(NamedTuple):
    """Motion of a node in one kind of vibration.

    Attributes
    ----------
    quantity : str
        Its name in diagrams.
    si : str
        Its unit in records.
    printed : str
        Its unit among those of `crankbase.tables.output_units`.
    unit : str
        The same as written in diagrams and reports.
    size : float
        Of that unit, in SI.
    """

    quantity: Literal["displacement", "twist"]
    si: str
    printed: str
    unit: str
    size: float

    def number(self, value: float, digits: int = 3) -> str:
        """Write an SI value in that unit, rounded to so many digits also before the point, as tables do."""
        return significant(float(f"{value / self.size:.{digits}g}"), digits)


def _motion(quantity: Literal["displacement", "twist"]) -> Motion:
    printed = VIBRATING[quantity]
    si, size = UNITS[printed]
    return Motion(quantity, si, printed, unit_symbol(printed), size)


MOTION = {"axial": _motion("displacement"), "torsional": _motion("twist")}
