"""Whether an engine fires evenly: a warning where it could, a note where its cranks forbid it."""

from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from crankfem.files.sections.engine_sections import Engine
from dynamics.engine.firing import EVEN, even_firing_order, least_uneven_order, repeating_intervals

# Intervals that differ so many times more than those of another order look like a slip.
MUCH = 2.0


@dataclass(frozen=True)
class FiringEvenness:
    """What to say of firing intervals that are not even.

    Attributes
    ----------
    warnings : tuple of str
        Of what looks like a slip.
    notes : tuple of str
        Of what only some engines have.
    """

    warnings: tuple[str, ...] = ()
    notes: tuple[str, ...] = ()


def firing_evenness(engine: Engine) -> FiringEvenness:
    """Compare the firing intervals of an engine with even ones.

    Engines in banks and those of one or two cylinders are often built with uneven intervals: where no
    firing order makes them even, or by far more even, that is a note.

    Parameters
    ----------
    engine : Engine
    """
    steps = engine.firing_intervals_deg
    if max(steps) - min(steps) < np.degrees(EVEN):
        return FiringEvenness()
    together = tuple(_together(engine))
    told = _shown(steps)
    even = even_firing_order(engine.firing_angles, engine.strokes)
    order = "-".join(map(str, engine.firing_order))
    if even is not None:
        every = sum(steps) / len(steps)
        better = (
            f"engine.firing_order: given {order}, which fires at uneven intervals of {told}; an order such "
            f"as {'-'.join(map(str, even))} fires every {every:g} deg with the same cranks"
        )
        return FiringEvenness((*together, better))
    banked = engine.bank_angles is not None
    angles = "crank and bank angles" if banked else "crank angles"
    fires = f"the cylinders fire at uneven intervals of {told}; no firing order is even with these {angles}"
    best = least_uneven_order(engine.firing_angles, engine.strokes)
    spread = max(steps) - min(steps)
    least = spread if best is None else np.degrees(max(best[1]) - min(best[1]))
    if best is not None and least < spread - np.degrees(EVEN):
        such = "-".join(map(str, best[0]))
        at = _shown([float(np.degrees(one)) for one in best[1]])
        fires += f", and the least uneven is such as {such} at {at}"
        if engine.cylinders > 2 and spread > MUCH * least:
            return FiringEvenness((*together, f"engine.firing_order: given {order}; {fires}"))
    elif best is not None:
        fires += ", or less uneven than this one"
    uneven = f"engine.crank_angles: {fires}"
    if banked or engine.cylinders < 3:
        return FiringEvenness(together, (uneven,))
    return FiringEvenness(
        (*together, f"{uneven}{_alone(engine)}, so check them unless the engine is built so")
    )


def firing_sentence(engine: Engine) -> str:
    """Say in which order and at which intervals an engine fires."""
    steps = engine.firing_intervals_deg
    order = "-".join(map(str, engine.firing_order))
    if max(steps) - min(steps) < np.degrees(EVEN):
        return f"Firing order {order}, even: every {sum(steps) / len(steps):g} deg."
    return f"Firing order {order}, uneven: intervals of {_shown(steps)}."


def _shown(intervals_deg: Sequence[float]) -> str:
    """Write intervals; of those that repeat, each once."""
    repeated = repeating_intervals(intervals_deg)
    again = " in turn" if 1 < len(repeated) < len(intervals_deg) else ""
    return f"{', '.join(f'{step:g}' for step in np.round(repeated, 1))} deg{again}"


def _together(engine: Engine) -> Iterator[str]:
    """Name cylinders that fire at the same angle."""
    order = engine.firing_order
    for place, step in enumerate(engine.firing_intervals_deg):
        if step < np.degrees(EVEN):
            number, following = order[place], order[(place + 1) % len(order)]
            yield f"engine.firing_order: cylinders {number} and {following} fire at the same time"


def _alone(engine: Engine) -> str:
    """Name the cylinders of a four-stroke engine in line that reach the top without another one."""
    if engine.strokes == 2 or engine.cylinders % 2:
        return ""
    tops = [round(float(angle) % 360.0, 1) % 360.0 for angle in np.degrees(engine.firing_angles)]
    shared = Counter(tops)
    alone = [str(place) for place, top in enumerate(tops, start=1) if shared[top] == 1]
    return f" (not in pairs at the top: cylinders {', '.join(alone)})" if alone else ""
