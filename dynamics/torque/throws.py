"""Cylinders of each throw of the crankshaft."""

import math
from collections.abc import Sequence

from crankbase.checks.scalars import is_whole
from crankbase.errors import InputError
from dynamics.engine.firing import IN_LINE
from dynamics.engine.layout import EngineLayout
from dynamics.indices import grouped

# Rods on one throw stand closer than this share of the bore: cylinders of a bank cannot.
CLOSE = 0.75


def throws_along_shaft(engine: EngineLayout) -> tuple[tuple[int, ...], ...]:
    """Return the numbers of the cylinders on each throw, from the free end to the flywheel.

    Cylinders share a throw if a rod of one is hinged to that of the other, or if their crank angles
    are equal, their banks differ and they are closer along the shaft than a bank allows. Throws
    at one position are in the order of their cylinders' numbers.
    """
    numbers = range(1, len(engine.cylinders) + 1)
    along = sorted(numbers, key=lambda number: (engine.cylinders[number - 1].position, number))
    mains = (number for number in along if engine.main_of(number) == number)
    throws = grouped(mains, lambda throw, number: _shares(engine, throw, number))
    for number in along:
        main = engine.main_of(number)
        if main != number:
            next(throw for throw in throws if main in throw).append(number)
    return tuple(tuple(sorted(throw)) for throw in throws)


def _shares(engine: EngineLayout, throw: list[int], number: int) -> bool:
    own = engine.cylinders[number - 1]
    for other in (engine.cylinders[member - 1] for member in throw):
        turned = math.remainder(
            math.radians(own.crank_angle_deg - other.crank_angle_deg), 2.0 * math.pi
        )
        leaning = math.remainder(
            math.radians(own.bank_angle_deg - other.bank_angle_deg), 2.0 * math.pi
        )
        apart = abs(own.position - other.position)
        if abs(turned) > IN_LINE or abs(leaning) <= IN_LINE or apart >= CLOSE * own.bore:
            return False
    return True


def checked_throws(engine: EngineLayout, throws: Sequence[int]) -> tuple[tuple[int, ...], ...]:
    """Return the numbers of the cylinders on each throw from the throw of each cylinder, from 0.

    Raises
    ------
    InputError
        If there is not one for each cylinder, one is not a whole number, or a throw has none.
    """
    given = list(throws)
    if len(given) != len(engine.cylinders):
        raise InputError(
            f"throws: given {len(given)}; allowed are {len(engine.cylinders)}, because each cylinder "
            "works on one."
        )
    if not all(is_whole(throw) for throw in given):
        raise InputError(
            f"throws: given {given}; allowed are whole numbers from 0 on, because throws are counted "
            "from the free end."
        )
    if sorted(set(given)) != list(range(max(given) + 1)):
        raise InputError(
            f"throws: given {given}; allowed are throws from 0 on without a gap, because each has a "
            "cylinder."
        )
    return tuple(
        tuple(place + 1 for place, own in enumerate(given) if own == throw)
        for throw in range(max(given) + 1)
    )
