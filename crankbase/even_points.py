"""Points spread evenly over every column, as `scipy.stats.qmc` draws them, without its second of loading."""

import numpy as np
from numpy.typing import NDArray

from crankbase.array_checks import Array

# Pairs of points whose products are held at a time.
AT_A_TIME = 1_000_000

# Primitive polynomials and first direction numbers of columns 2 to 40 (Joe and Kuo 2008, new-joe-kuo-6).
DIRECTIONS = """
3:1 7:1,3 11:1,3,1 13:1,1,1 19:1,1,3,3 25:1,3,5,13 37:1,1,5,5,17 41:1,1,5,5,5 47:1,1,7,11,19 55:1,1,5,1,1
59:1,1,1,3,11 61:1,3,5,5,31 67:1,3,3,9,7,49 91:1,1,1,15,21,21 97:1,3,1,13,27,49 103:1,1,1,15,7,5
109:1,3,1,15,13,25 115:1,1,5,5,19,61 131:1,3,7,11,23,15,103 137:1,3,7,13,13,15,69 143:1,1,3,13,7,35,63
145:1,3,5,9,1,25,53 157:1,3,1,13,9,35,107 167:1,3,1,5,27,61,31 171:1,1,5,11,19,41,61 185:1,3,5,3,3,13,69
191:1,1,7,13,1,19,1 193:1,3,7,5,13,19,59 203:1,1,3,9,25,29,41 211:1,3,5,13,23,1,55 213:1,3,7,3,13,59,17
229:1,3,1,3,5,53,69 239:1,1,5,5,23,33,13 241:1,1,7,7,1,61,123 247:1,1,7,9,13,61,49 253:1,3,3,5,3,55,33
285:1,3,1,15,31,13,49,245 299:1,3,5,15,31,59,63,97 301:1,3,1,11,11,11,77,249
"""


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


def sobol_sequence(
    count: int, columns: int, start: np.random.Generator | int, bits: int = 30
) -> Array:
    """Draw the first points (n, k) of a Sobol sequence within [0, 1), scrambled (Matousek 1998) and shifted.

    To the last bit those of ``qmc.Sobol(columns, rng=start, bits=bits).random(count)``.
    """
    if columns > len(DIRECTIONS.split()) + 1:
        from scipy.stats import qmc  # here: loading it takes a second

        return qmc.Sobol(columns, rng=start, bits=bits).random(count)
    random = np.random.default_rng(start).spawn(1)[0]
    places, number = np.arange(bits, dtype=np.uint64), np.uint32 if bits <= 32 else np.uint64
    shift = random.integers(2, size=(columns, bits), dtype=number).astype(np.uint64) @ (
        np.uint64(1) << places
    )
    lower = np.tril(random.integers(2, size=(columns, bits, bits), dtype=number), -1) + np.eye(bits)
    digits = (_directions(columns, bits)[:, :, None] >> places[::-1]) & np.uint64(1)
    scrambled = (digits.astype(np.float64) @ lower.transpose(0, 2, 1) % 2.0).astype(np.uint64)
    points = shift[None]
    # In the order of Gray's code: each doubling is the sequence backwards with one more digit.
    for step in (scrambled << places[::-1]).sum(axis=2, dtype=np.uint64).T:
        if len(points) >= count:
            break
        points = np.concatenate([points, points[::-1] ^ step])
    return points[:count] * 0.5**bits


def _directions(columns: int, bits: int) -> NDArray[np.uint64]:
    """Direction numbers (k, bits) of the first columns, as whole numbers of so many bits."""
    rows = [[1] * bits]
    for entry in DIRECTIONS.split()[: columns - 1]:
        polynomial, _, first = entry.partition(":")
        row = [int(number) for number in first.split(",")]
        taken = [back + 1 for back, one in enumerate(f"{int(polynomial):b}"[1:]) if one == "1"]
        degree = len(row)
        while len(row) < bits:
            number = row[-degree]
            for back in taken:
                number ^= row[-back] << back
            row.append(number)
        rows.append(row[:bits])
    return np.array(
        [[number << bits - 1 - place for place, number in enumerate(row)] for row in rows],
        dtype=np.uint64,
    )


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
