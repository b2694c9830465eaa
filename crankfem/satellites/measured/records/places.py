"""Places of samples, times or crank angles: whether they are even, their unit, and their digits."""

import math

import numpy as np

from crankbase.array_checks import Array
from crankbase.errors import InputError
from crankbase.units import size_in
from crankfem.satellites.measured.records.record import SAMPLES, Column

# Of so many places the extremes are kept, to tell whether all are even.
BLOCK = 1000
# Places that are off even ones by no more than this share of a step are even.
ROUND_OFF = 1e-6
# A rate [1/s] is taken as a whole number if its error is smaller, so that no other one is possible; the steps
# of a turn as one, if theirs is.
SURE, SURE_OF_STEPS = 0.5, 0.1
# Of the usual step this share at most is lost by the digits of uneven places.
LARGEST_ERROR = 0.01
# Fewer angles do not tell their unit; a turn ends at a sample within this share of a step.
FEWEST_ANGLES, AT_SAMPLE = 8, 0.02
TURNS = {"deg": 360.0, "rad": 2.0 * math.pi}


def even_places(places: Column, error: float) -> tuple[float, float] | None:
    """Return start and step of places that are even but for their digits; None of others.

    They are read once, in pieces: of each block the extremes around a line through the first piece are kept.

    Examples
    --------
    >>> even_places(Column.of([0.0, 0.0003, 0.0007, 0.001]), error=0.5e-4)
    (0.0, 0.00034)
    """
    start = step = 0.0
    count, blocks = 0, []
    for piece in places.read(SAMPLES):
        index = np.arange(count, count + piece.size, dtype=np.float64)
        if count == 0:
            start, step = float(piece[0]), _slope(index, piece - piece[0])
        off = (piece - start) - step * index
        begins = np.arange(0, piece.size, BLOCK)
        ends = np.minimum(begins + BLOCK, piece.size) - 1
        extremes = [each.reduceat(off, begins) for each in (np.minimum, np.maximum)]
        blocks.append(np.array([*extremes, 0.5 * (index[begins] + index[ends])]))
        count += piece.size
    if count < 2:
        return None
    low, high, middle = np.concatenate(blocks, axis=1)
    step_error = _slope(middle, 0.5 * (low + high))
    level = float(np.mean(0.5 * (low + high))) if middle.size > 1 else float(np.mean(off))
    off = np.array([low, high]) - level - step_error * (middle - np.mean(middle))
    step += step_error
    if step <= 0.0 or not np.max(np.abs(off)) <= max(2.0 * error, ROUND_OFF * step):
        return None
    return start, step


def _slope(index: Array, values: Array) -> float:
    """Return the slope of the line through values, shape (n,), zero of one alone."""
    centered = index - np.mean(index)
    return float(centered @ values / (centered @ centered)) if index.size > 1 else 0.0


def step_error(step: float, count: int, error: float) -> float:
    """Return the share of a step by which it may be wrong, of so many places with an error each."""
    return 2.0 * error / (max(count - 1, 1) * step) + ROUND_OFF / max(count - 1, 1)


def whole_rate(step: float, count: int, error: float) -> float:
    """Return samples in a second, of steps [s]: a whole number if their digits leave no other.

    Examples
    --------
    >>> whole_rate(2.08333e-5, 48000, 5e-11 * 47999)
    48000.0
    """
    rate = 1.0 / step
    uncertain = 2.0 * rate * step_error(step, count, error)
    return float(round(rate)) if abs(rate - round(rate)) <= uncertain < SURE else rate


def digits_fault(unit: str, places: Array, error: float) -> tuple[str, bool]:
    """Say how many digits of places, shape (n,), such as times of pulses, are lost, and whether too many are.

    Nothing is said if the error is below a hundredth of the usual step. Steps that are whole multiples of the
    smallest one may be exact.
    """
    steps = np.diff(places)
    usual, least = (float(np.median(steps)), float(np.min(steps))) if steps.size else (0.0, 0.0)
    if not steps.size or error <= LARGEST_ERROR * usual:
        return "", False
    has = f"errors up to {error:.2g} {unit} by their digits"
    off = steps - least * np.round(steps / least) if least > 0.0 else np.array(error)
    if np.all(np.abs(off) < 0.1 * error):
        return f"has {has}, unless they are exact", False
    same = int(np.count_nonzero(steps == 0.0))
    return (
        f"given uneven places with {has}, while their usual step is {usual:.2g} {unit} and {same} of "
        f"{places.size} fall together; allowed is an error of {LARGEST_ERROR * usual:.1g} {unit}: export "
        "them with more digits, or in binary form"
    ), True


def check_rising(name: str, unit: str, places: Array) -> None:
    """Refuse places, shape (n,), that go back.

    Raises
    ------
    InputError
    """
    back = np.flatnonzero(np.diff(places) < 0.0)
    if back.size:
        before, after = places[back[0] : back[0] + 2]
        raise InputError(
            f"{name}: given {after:.9g} {unit} after {before:.9g} {unit} in sample {back[0] + 2}; allowed "
            "are places that increase, because samples follow each other."
        )


def continued(angles: Array, unit: str) -> Array:
    """Return angles, shape (n,), that begin again with each turn or cycle as angles that are counted on."""
    steps = np.diff(angles)
    if not np.any(steps < 0.0) or not unit:
        return angles
    turn = 2.0 * np.pi / size_in(unit, "rad")[0]
    usual = float(np.nanmedian(steps))
    turns = np.where(steps < -0.4 * turn, np.round((usual - steps) / turn), 0.0)
    return angles + turn * np.concatenate([[0.0], np.cumsum(turns)])


def settled_unit(unit: str, angles: Array, error: float) -> tuple[str, str]:
    """Return the unit of crank angles, shape (n,), and what speaks against the one that is written.

    Radians may be labeled degrees, and the other way round: a turn is a whole number of steps, and a record
    one of turns, in one of the two alone.

    Examples
    --------
    >>> settled_unit("deg", np.linspace(0.0, 12.566370614359172, 721), 0.0)[0]
    'rad'
    """
    falls = np.flatnonzero(np.diff(angles) < 0.0)
    first = angles[: falls[0] + 1] if falls.size else angles
    span = float(first[-1] - first[0]) if first.size else 0.0
    sizes = {name: size_in(name, "rad")[0] for name in TURNS}
    label = [
        name for name, size in sizes.items() if unit and math.isclose(size, size_in(unit, "rad")[0])
    ]
    if first.size < FEWEST_ANGLES or span <= 0.0 or (unit and not label):
        return unit, ""
    step = span / (first.size - 1)
    room = step_error(step, first.size, error) + ROUND_OFF
    even = even_places(Column.of(first), error) is not None

    def fits(turn: float) -> bool:
        steps = turn / step
        divides = even and abs(steps - round(steps)) <= room * steps < SURE_OF_STEPS
        ends = (span / turn, span / turn + 1.0 / steps)
        return divides or any(
            round(end) and abs(end - round(end)) * steps < AT_SAMPLE for end in ends
        )

    fitting = [name for name, turn in TURNS.items() if fits(turn)]
    if len(fitting) != 1 or fitting == label:
        return unit, ""
    return fitting[0], (
        f"is taken in {fitting[0]}, not in {unit or 'an unknown unit'}: from {first[0]:.6g} to "
        f"{first[-1]:.6g} in steps of {step:.6g} it is turns in {fitting[0]} alone"
    )
