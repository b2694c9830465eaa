"""The lateral stiffness of an engine's main bearings, given or assumed."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from crankbase.summaries import summarized
from crankbase.units.number_formats import compact
from crankfem.files.engine.engine_file import EngineFile

# Lateral stiffness of a main bearing (oil film, cap and wall) per journal diameter, where the file gives
# none. An assumption of the order of magnitude, no measurement: it makes 0.5e9 N/m of a journal of 50 mm
# and 2e9 N/m of one of 200 mm; hence a range of ten times less to ten times more.
ASSUMED_PER_DIAMETER = 1e10  # N/m per m
ASSUMED_RANGE = 10.0
# Steps of the range on either side of the nominal value: seven values in all.
STEPS = 3


@summarized("nominal [N/m]", "lowest [N/m]", "highest [N/m]", "assumed")
@dataclass(frozen=True)
class BearingStiffness:
    """Lateral stiffness of each main bearing with its housing, and its possible range.

    The journals' compliances in the chains and the whole crankshaft depend on the same value.

    Attributes
    ----------
    nominal, lowest, highest : float
        [N/m]; equal to the nominal value if the file gives a stiffness without a range.
    assumed : bool
        Whether the file gives none.
    """

    nominal: float
    lowest: float
    highest: float
    assumed: bool

    @property
    def sweep(self) -> NDArray[np.float64]:
        """Seven values over the range, with equal ratios on either side of the nominal one in the middle.

        A single value if there is no range.
        """
        if self.lowest == self.highest:
            return np.array([self.nominal])
        below = np.geomspace(self.lowest, self.nominal, STEPS + 1)
        above = np.geomspace(self.nominal, self.highest, STEPS + 1)
        return np.concatenate((below, above[1:]))

    def describe(self) -> str:
        """Return the stiffness and its range in a clause."""
        text = f"lateral stiffness of {compact(self.nominal)} N/m each"
        if self.lowest < self.highest:
            text += f" (range {compact(self.lowest)} to {compact(self.highest)})"
        return text


def bearing_stiffness(engine_file: EngineFile) -> BearingStiffness:
    """Return the lateral stiffness of an engine's main bearings, given or assumed."""
    given = engine_file.bearings
    if given is None:
        assumed = ASSUMED_PER_DIAMETER * engine_file.throw.main_journal_diameter
        return BearingStiffness(assumed, assumed / ASSUMED_RANGE, assumed * ASSUMED_RANGE, True)
    return BearingStiffness(
        given.stiffness,
        given.lowest_stiffness or given.stiffness,
        given.highest_stiffness or given.stiffness,
        False,
    )
