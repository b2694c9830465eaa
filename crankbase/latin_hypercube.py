"""Points spread evenly over every column, as `scipy.stats.qmc` draws them, without its second of loading."""

import numpy as np

from crankbase.array_checks import Array

# Pairs of points whose products are held at a time.
AT_A_TIME = 1_000_000


def latin_hypercube(count: int, columns: int, random: np.random.Generator) -> Array:
    """Draw a Latin hypercube (n, k) within [0, 1): each column in n strata, one point in each (McKay 1979).

    To the last bit the points of ``qmc.LatinHypercube(columns, rng=start).random(count)``, where `random` is
    ``start.spawn(1)[0]``; of several hypercubes from one generator those of several calls there.
    """
    within = random.uniform(size=(count, columns))
    strata = np.tile(np.arange(1, count + 1), (columns, 1))
    for column in strata:
        random.shuffle(column)
    drawn: Array = (strata.T - within) / count
    return drawn


def centered_discrepancy(points: Array) -> float:
    """Return the squared centered L2 discrepancy of points (n, k) in the unit cube (Hickernell 1998).

    To the last bit that of ``qmc.discrepancy(points)``: summed in its order.
    """
    count, rows = len(points), max(1, AT_A_TIME // len(points))
    off = np.abs(points - 0.5)
    alone = np.add.accumulate(np.prod(1.0 + 0.5 * off - 0.5 * off**2, axis=1))[-1]
    together = 0.0
    for first in range(0, count, rows):
        some = slice(first, first + rows)
        products = np.ones((len(points[some]), count))
        for column, far in zip(points.T, off.T, strict=True):
            apart = np.abs(column[some, None] - column)
            products *= 1.0 + 0.5 * far[some, None] + 0.5 * far - 0.5 * apart
        products[0, 0] += together
        together = np.add.accumulate(products.ravel())[-1]
    whole = (13.0 / 12.0) ** points.shape[1]
    return float(whole - 2.0 / count * alone + 1.0 / count**2 * together)
