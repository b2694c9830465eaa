"""Angles given in degrees: checks, conversion to radians, refusal of evident radians."""

from collections.abc import Iterable

import numpy as np
from numpy.typing import ArrayLike

from crankbase.checks.arrays import FloatArray, finite_array, finite_vector
from crankbase.errors import InputError

TURNS = (2.0 * np.pi, 4.0 * np.pi)
# Even angles from so many on are held for radians where they cover a turn or two of these, but for rounding.
FEWEST_EVEN, SAME = 8, 1e-6
# Cranks divide a turn into so many parts; how close radians with two decimals, of two cranks with three, lie
# to such parts [deg].
PARTS, ROUNDED, ROUNDED_PAIR = np.arange(2, 13), 0.3, 0.1


def checked_degrees(field: str, angles_deg: ArrayLike, *, vector: bool = False) -> FloatArray:
    """Return angles given in degrees as an array, of the same shape.

    Parameters
    ----------
    field : str
        Name of the values in messages.
    angles_deg : array_like
    vector : bool, optional
        Whether they must be of shape (m,).

    Raises
    ------
    InputError
        If one is not a finite number, or they are evenly spread over 2 pi or 4 pi: nobody uses so many
        even steps over 6.283 or 12.566 degrees.
    """
    given = (finite_vector if vector else finite_array)(field, angles_deg)
    if given.ndim == 1 and given.size >= FEWEST_EVEN:
        step = (given[-1] - given[0]) / (given.size - 1)
        even = np.allclose(np.diff(given), step, rtol=0.0, atol=SAME * abs(step))
        lengths = abs(step) * np.array([[given.size - 1], [given.size]])
        if even and np.any(np.isclose(lengths, TURNS, rtol=SAME, atol=0.0)):
            raise _radians_error(field, given)
    return given


def refuse_many_turns(field: str, angles: Iterable[float]) -> None:
    """Refuse angles of more than two turns [rad], which are probably degrees: (0, 120, 240).

    Raises
    ------
    InputError
    """
    largest = max(angles, key=abs, default=0.0)
    if abs(largest) > TURNS[-1] * (1.0 + SAME):
        raise InputError(
            f"{field}: given {largest:g} rad, more than two turns; allowed is -4 pi to 4 pi (-720 to 720 "
            "deg). In Python, angles of records are radians: write math.radians(...) around degrees."
        )


def radians_of(field: str, angles_deg: ArrayLike, *, vector: bool = False) -> FloatArray:
    """Return angles given in degrees as radians; as `checked_degrees`."""
    return np.radians(checked_degrees(field, angles_deg, vector=vector))


def refuse_crank_radians(field: str, angles_deg: ArrayLike) -> None:
    """Refuse angles of cranks, or at which cylinders fire, that are radians: [0, 2.09, 4.19].

    Interpreted as radians they are all within two revolutions and simple fractions of one, one twelfth or
    more, but they are not round numbers of degrees.

    Raises
    ------
    InputError
    """
    given = finite_array(field, angles_deg).ravel()
    if given.size < 2 or np.max(np.abs(given)) > TURNS[-1] or np.ptp(given) < 1.0:
        return
    taken, steps = np.degrees(given)[:, np.newaxis], 360.0 / PARTS
    off = np.min(np.max(np.abs(taken - steps * np.round(taken / steps)), axis=0))
    halves = np.abs(2.0 * given - np.round(2.0 * given)) < SAME
    if off <= (ROUNDED if given.size > 2 else ROUNDED_PAIR) and not np.all(halves):
        raise _radians_error(field, given)


def refuse_radians_between(field: str, angle_deg: float, low_deg: float, high_deg: float) -> None:
    """Refuse one angle in degrees that is within given bounds if interpreted as radians.

    For angles that are always more than a few degrees.

    Raises
    ------
    InputError
    """
    taken = float(np.degrees(angle_deg))
    if low_deg < taken < high_deg:
        raise InputError(
            f"{field}: given {angle_deg:.6g} deg, which would be {taken:.4g} deg if it were radians; allowed "
            "are degrees: write numpy.degrees(...) around it."
        )


def _radians_error(field: str, given: FloatArray) -> InputError:
    return InputError(
        f"{field}: given {given.size} angles from {np.min(given):.4g} to {np.max(given):.4g}, those of "
        "turns in radians; allowed are degrees: write numpy.degrees(...) around them."
    )
