"""Designs for quadratic equations: central composite and Box-Behnken, in coded units of -1 to 1."""

import numpy as np
from numpy.typing import NDArray

from crankbase.errors import InputError
from regression.plans.designs_factorial import corner_fraction

FACES = ("faced", "inscribed", "circumscribed")
# pydoe builds these from a list of all pairs; 30 factors make 1741 runs.
MOST_FACTORS = 30


def central_composite(factors: int, face: str, resolution: int | None) -> NDArray[np.float64]:
    """Return corners, stars and the center, all inside the box.

    Parameters
    ----------
    factors : int
        2 or more.
    face : str
        "faced": corners and the middles of the faces, three levels. "inscribed": stars in the middles
        of the faces and corners moved in to 1 / alpha, rotatable with alpha = (number of corners)^(1/4),
        five levels. "circumscribed" has its stars outside the corners; scaled down until they are in
        the box, it is the inscribed design.
    resolution : int, optional
        Of the fraction of the corners; all corners if None.

    Returns
    -------
    (n, factors) ndarray
        Within -1 to 1; the center once, because finite elements repeat exactly.

    Raises
    ------
    InputError
        If there are too few factors.
    """
    from pydoe import ff2n, star

    if not 2 <= factors <= MOST_FACTORS:
        raise InputError(
            f"study.design: given 'central composite' with {factors} factors that are numbers; allowed "
            f"are 2 to {MOST_FACTORS}."
        )
    corners = (
        np.asarray(ff2n(factors), dtype=np.float64)
        if resolution is None
        else corner_fraction(factors, resolution)
    )
    stars, _ = star(factors)
    if face != "faced":
        corners = corners / len(corners) ** 0.25
    return np.vstack([corners, stars, np.zeros((1, factors))])


def box_behnken(factors: int) -> NDArray[np.float64]:
    """Return the middles of the edges in each plane of two factors, and the center once.

    Parameters
    ----------
    factors : int
        3 or more.

    Returns
    -------
    (2 k (k - 1) + 1, k) ndarray
        Of -1, 0 and 1.

    Raises
    ------
    InputError
        If there are too few factors.
    """
    from pydoe import bbdesign

    if not 3 <= factors <= MOST_FACTORS:
        raise InputError(
            f"study.design: given 'box-behnken' with {factors} factors that are numbers; allowed are "
            f"3 to {MOST_FACTORS}, because it varies two at a time while others rest in the middle."
        )
    return np.asarray(bbdesign(factors, center=1), dtype=np.float64)
