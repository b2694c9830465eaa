"""Designs on the corners of a box: two-level fractions, their resolution and confounded effects."""

import itertools

import numpy as np
from numpy.typing import NDArray

from crankbase.errors import InputError

ROMAN = {3: "III", 4: "IV", 5: "V", 6: "VI", 7: "VII", 8: "VIII"}
# Products of columns examined for the shortest word of a fraction.
LARGEST_SEARCH = 300_000

Coded = NDArray[np.float64]


def corner_fraction(factors: int, resolution: int) -> Coded:
    """Return a regular fraction of the corners of a cube, of at least a resolution.

    The smallest found by `pydoe.fracfact_by_res`; all corners if no fraction is sufficient.

    Parameters
    ----------
    factors : int
        2 or more.
    resolution : int
        3 to 8: no product of fewer columns is constant.

    Returns
    -------
    (n, factors) ndarray
        Of -1 and 1.

    Raises
    ------
    InputError
        If no such design is found.
    """
    from pydoe import ff2n, fracfact_by_res

    if factors < 3:
        return np.asarray(ff2n(factors), dtype=np.float64)
    try:
        return np.asarray(fracfact_by_res(factors, resolution), dtype=np.float64)
    except ValueError as error:
        raise InputError(
            f"study.resolution: given {ROMAN[resolution]} for {factors} factors; allowed is a lower "
            f"resolution or fewer factors, because no such design is known ({error})."
        ) from None


def corners_by_generators(generators: str, factors: int) -> Coded:
    """Return the fraction that generators such as "a b c abc" describe.

    Parameters
    ----------
    generators : str
        One word for each factor: single letters a, b, c ... vary freely, longer words are their
        products, with - in front for the opposite sign.
    factors : int

    Raises
    ------
    InputError
        If they are not generators, or for another number of factors.
    """
    from pydoe import fracfact

    words = generators.split()
    try:
        if len(words) != factors:
            raise ValueError(f"{len(words)} words for {factors} factors of two levels")
        found = np.asarray(fracfact(" ".join(words)), dtype=np.float64)
    except (ValueError, IndexError) as error:
        raise InputError(
            f"study.generators: given {generators!r}; allowed is one word for each factor, like "
            f'"a b c abc" ({str(error).rstrip(".")}).'
        ) from None
    return found


def resolution_of(design: Coded) -> int | None:
    """Return the length of the shortest product of columns that is constant, or None.

    Parameters
    ----------
    design : (n, k) ndarray
        Of -1 and 1.

    Returns
    -------
    int or None
        The resolution; None for all corners, where nothing is confounded, or if the search up to
        `LARGEST_SEARCH` products finds none.
    """
    columns, everything = _as_bits(design)
    if len(np.unique(design, axis=0)) == 2 ** design.shape[1]:
        return None
    searched = 0
    for length in range(1, len(columns) + 1):
        for chosen in itertools.combinations(columns, length):
            product = 0
            for column in chosen:
                product ^= column
            if product in (0, everything):
                return length
            searched += 1
            if searched > LARGEST_SEARCH:
                return None
    return None


def aliased_effects(design: Coded, names: tuple[str, ...]) -> tuple[str, ...]:
    """List aliased effects: main effects and two-factor interactions confounded in a fraction.

    Parameters
    ----------
    design : (n, k) ndarray
        Of -1 and 1.
    names : tuple of str
        Of the factors.

    Returns
    -------
    tuple of str
        Groups such as ``"web_width = pin_length x web_thickness"``; groups of one effect are left out.
    """
    columns, everything = _as_bits(design)
    groups: dict[int, list[str]] = {}
    for length in (1, 2):
        for places in itertools.combinations(range(len(columns)), length):
            product = 0
            for place in places:
                product ^= columns[place]
            # An effect and its negative cannot be told apart either; a product of two columns is
            # the complement of the bits' difference.
            key = min(product, product ^ everything)
            groups.setdefault(key, []).append(" x ".join(names[place] for place in places))
    return tuple(" = ".join(group) for group in groups.values() if len(group) > 1)


def _as_bits(design: Coded) -> tuple[list[int], int]:
    """Write each column as an integer, one bit for each run, and the integer of all ones."""
    bits = [int("".join("1" if value > 0.0 else "0" for value in column), 2) for column in design.T]
    return bits, (1 << len(design)) - 1
