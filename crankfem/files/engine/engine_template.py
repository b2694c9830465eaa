"""A template for one's own engine file: every section explained, optional parts in comments."""

import math
from importlib.resources import files
from string import Template

from crankbase.errors import InputError

# Orders in which cylinders in line usually fire, by strokes per cycle; the cranks follow from them, for
# firing is even.
FIRING_ORDERS: dict[int, dict[int, tuple[int, ...]]] = {
    4: {
        1: (1,),
        2: (1, 2),
        3: (1, 3, 2),
        4: (1, 3, 4, 2),
        5: (1, 2, 4, 5, 3),
        6: (1, 5, 3, 6, 2, 4),
        7: (1, 3, 5, 7, 6, 4, 2),
        8: (1, 6, 2, 5, 8, 3, 7, 4),
    },
    2: {
        1: (1,),
        2: (1, 2),
        3: (1, 3, 2),
        4: (1, 3, 2, 4),
        5: (1, 4, 3, 2, 5),
        6: (1, 5, 3, 4, 2, 6),
        7: (1, 7, 2, 5, 4, 3, 6),
        8: (1, 8, 3, 4, 7, 2, 5, 6),
    },
}


def engine_template(file: str = "mine.toml", cylinders: int = 6, strokes: int = 4) -> str:
    """Return the text of an engine file that can be run unchanged.

    Parameters
    ----------
    file : str
        Its name, for the commands in it.
    cylinders : int
        In line.
    strokes : int
        Per cycle, 2 or 4.

    Raises
    ------
    InputError
        If no usual firing order is known.
    """
    if strokes not in FIRING_ORDERS:
        raise InputError(
            f"--strokes: given {strokes}; allowed are 2 and 4, because cycles have as many strokes."
        )
    known = FIRING_ORDERS[strokes]
    if cylinders not in known:
        raise InputError(
            f"--cylinders: given {cylinders}; allowed is 1 to {max(known)}, because for these in line the "
            "firing order is usual; write any other into the file."
        )
    order = known[cylinders]
    angles = crank_angles_deg(order, strokes)
    counted = "cylinder" if cylinders == 1 else "cylinders"
    return Template(_text()).substitute(
        title=f"{cylinders} {counted} in line, {strokes}-stroke",
        file=file,
        name=f"Example, {cylinders} {counted}",
        cylinders=cylinders,
        strokes=strokes,
        thrust=cylinders + 1,
        crank_angles=", ".join(f'"{angle:.10g} deg"' for angle in angles),
        firing_order=", ".join(map(str, order)),
    )


def crank_angles_deg(firing_order: tuple[int, ...], strokes: int) -> list[float]:
    """Return the angle of each crank from the first in the sense of rotation [deg].

    With these the firing intervals are even.

    Examples
    --------
    >>> crank_angles_deg((1, 5, 3, 6, 2, 4), 4)
    [0.0, 240.0, 120.0, 120.0, 240.0, 0.0]
    """
    cycle = 180.0 * strokes
    found = [math.nan] * len(firing_order)
    for place, cylinder in enumerate(firing_order):
        # A cylinder that fires later has its crank so much behind the first.
        found[cylinder - 1] = round(-place * cycle / len(firing_order) % 360.0, 9) % 360.0
    return found


def _text() -> str:
    return files("crankfem.files.engine").joinpath("template.toml").read_text(encoding="utf-8")
