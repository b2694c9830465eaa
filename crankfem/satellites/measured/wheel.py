"""A toothed wheel: which tooth each pulse is, by its gap or its double tooth, and what is mended."""

import re
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from crankbase.array_checks import Array, Flags, Integers, finite_vector
from crankbase.choices import check_some
from crankbase.errors import InputError, quoted
from crankbase.results import result

# Neighboring intervals whose median is the pitch.
NEIGHBORS = 7
# An interval below this share of a pitch has one pulse too many; a double tooth's are between these shares.
DOUBLED = 0.4
HALF_PITCH = (0.3, 0.7)
# A gap may be wider by so many pitches, and by more where its revolutions have all of their pulses.
WIDER = 0.7
# Marks on either side that a mark must agree with, and the least share of revolutions with one.
AGREEING, MARKED = 5, 0.5
# More teeth lost or doubled than this share: the wheel is not as it is said to be.
MOST_MENDED = 0.2


@dataclass(frozen=True)
class Wheel:
    """Evenly spaced teeth of which some may be missing, or one is double.

    Attributes
    ----------
    pitches : int
        Pitches of a revolution.
    missing : int
        Teeth missing in the gap, the last ones of a revolution.
    double : bool
        Whether an additional tooth stands in the middle of the last pitch.
    """

    pitches: int
    missing: int = 0
    double: bool = False

    @classmethod
    def read(cls, text: str) -> "Wheel":
        """Read "60-2", "60+1" or "120".

        Raises
        ------
        InputError
            If it is none of these.
        """
        parts = re.fullmatch(r"\s*(\d{1,4})\s*(?:([-+])\s*(\d{1,2}))?\s*", str(text))
        pitches, sign, count = parts.groups() if parts else ("0", None, None)
        size, other = int(pitches), int(count or 0)
        wrong = (
            size < 1
            or (sign == "+" and other != 1)
            or (sign == "-" and not 1 <= other <= size // 4)
        )
        if parts is None or wrong:
            raise InputError(
                f"teeth: given {quoted(str(text))}; allowed are a number of teeth, like 120, one with "
                'missing teeth, like "60-2", or one with a double tooth, like "60+1", because the pulses are '
                "counted by them."
            )
        return cls(size, other if sign == "-" else 0, sign == "+")

    @property
    def marked(self) -> bool:
        """Whether it tells where a revolution begins."""
        return bool(self.missing) or self.double or self.pitches == 1

    @property
    def highest_order(self) -> float:
        """Order that two teeth show to each wave."""
        return 0.5 * self.pitches

    def __str__(self) -> str:
        more = f"-{self.missing}" if self.missing else "+1" if self.double else ""
        return f"{self.pitches}{more}"


@result("revolutions", "lost", "doubled")
class Teeth:
    """Pulses with the tooth of each.

    Attributes
    ----------
    time : ndarray of shape (n,)
        [s].
    number : ndarray of shape (n,)
        Pitches from the first mark; multiples of the wheel's pitches are the first tooth behind the mark.
    lost, doubled : int
        Pulses that were missing, and that were too many.
    unsure : int
        Pulses left out where pitches were lost between two marks.
    """

    wheel: Wheel
    time: Array
    number: Integers
    lost: int
    doubled: int
    unsure: int

    @property
    def angle(self) -> Array:
        """Angle of the sensor's place at each pulse, by an even wheel [rad], (n,)."""
        return np.asarray(2.0 * np.pi / self.wheel.pitches * self.number)

    @property
    def revolutions(self) -> float:
        """Of the whole record."""
        return float(self.number[-1] - self.number[0]) / self.wheel.pitches

    @property
    def notes(self) -> tuple[str, ...]:
        """What was mended."""
        counts = (
            (self.lost, "lost teeth were skipped"),
            (self.doubled, "doubled pulses were left out"),
            (self.unsure, "pulses were left out where teeth were lost from one mark to the next"),
        )
        return tuple(f"{count} {words}." for count, words in counts if count)


def number_teeth(times: ArrayLike, wheel: Wheel) -> Teeth:
    """Find the tooth of each pulse.

    Parameters
    ----------
    times : array_like of shape (n,)
        Ascending [s].

    Raises
    ------
    InputError
        If the times do not ascend, are too few, or the pulses are not those of such a wheel.
    """
    time = finite_vector("pulse_time_s", times)
    check_some("pulse_time_s", time, "the teeth are counted by them")
    falling = np.flatnonzero(np.diff(time) <= 0.0)
    if falling.size:
        place = int(falling[0]) + 1
        raise InputError(
            f"pulse_time_s[{place}]: given {time[place]:.9g} s after {time[place - 1]:.9g} s; allowed are "
            "ascending times; if the file has few digits, equal ones are a sign of it."
        )
    per_turn = wheel.pitches - wheel.missing + wheel.double
    if time.size < 4 * per_turn + 2:
        raise InputError(
            f"pulse_time_s: given {time.size} pulses; allowed are those of at least 4 revolutions, "
            f"{4 * per_turn + 2} of a wheel {wheel}, because orders are told apart over these."
        )
    extra = _double_teeth(time) if wheel.double else np.zeros(time.size, dtype=bool)
    behind = np.searchsorted(np.flatnonzero(~extra), np.flatnonzero(extra))
    kept = _without_doubled(time[~extra])
    doubled = int(np.count_nonzero(~extra)) - int(np.count_nonzero(kept))
    # A double tooth stands before the first tooth of a revolution, as a gap does.
    firsts = np.concatenate(([0], np.cumsum(kept)))[np.minimum(behind, kept.size)]
    time = time[~extra][kept]
    shares = _pitches_of(time)
    steps = np.maximum(np.rint(shares), 1.0).astype(np.int64)
    if wheel.missing:
        _count_whole_turns(steps, shares, wheel)
    number = np.concatenate(([0], np.cumsum(steps)))
    sure = np.ones(number.size, dtype=bool)
    if wheel.missing or wheel.double:
        behind_gaps = np.flatnonzero(steps == wheel.missing + 1) + 1
        marks = firsts[firsts < time.size] if wheel.double else behind_gaps
        number, sure = _by_marks(number, marks, steps, wheel)
    present = np.arange(number[0], number[-1] + 1) % wheel.pitches < wheel.pitches - wheel.missing
    lost = int(np.count_nonzero(present)) - number.size
    if not wheel.marked and _wheel_like(steps) is not None:
        raise _not_this(steps, wheel, f"of {number.size} pulses {lost} are missing")
    if max(lost, doubled) > MOST_MENDED * number.size:
        raise _not_this(
            steps, wheel, f"beside {number.size} pulses {lost} are missing, {doubled} doubled"
        )
    return Teeth(wheel, time[sure], number[sure], lost, doubled, int(np.count_nonzero(~sure)))


def _pitches_of(time: Array) -> Array:
    """Return each interval in pitches, the median of its neighbors."""
    from scipy.ndimage import median_filter

    steps = np.diff(time)
    return np.asarray(steps / median_filter(steps, NEIGHBORS, mode="nearest"))


def _double_teeth(time: Array) -> Flags:
    """Return which pulses stand in the middle of a pitch."""
    shares = _pitches_of(time)
    low, high = HALF_PITCH
    half = (shares > low) & (shares < high)
    middle = np.zeros(time.size, dtype=bool)
    middle[1:-1] = half[:-1] & half[1:]
    # Of three halves in a row one pulse alone is the middle.
    middle[1:] &= ~middle[:-1]
    return middle


def _without_doubled(time: Array) -> Flags:
    """Return which pulses remain where two came for one tooth: the one that fits the pitch better."""
    kept = np.ones(time.size, dtype=bool)
    for _ in range(3):
        places = np.flatnonzero(kept)
        shares = _pitches_of(time[places])
        short = np.flatnonzero(shares < DOUBLED)
        if not short.size:
            break
        padded = np.concatenate(([1.0], shares, [1.0]))
        before, between, after = padded[short], padded[short + 1], padded[short + 2]

        def off(values: Array) -> Array:
            return np.asarray(np.abs(values - np.rint(values)))

        first = off(before + between) + off(after) < off(before) + off(between + after)
        kept[places[np.where(first, short, short + 1)]] = False
    return kept


def _count_whole_turns(steps: Integers, shares: Array, wheel: Wheel) -> None:
    """Set the pitches of intervals from one gap to the next with as many pulses as there are teeth.

    Teeth beside a gap make it wider, and so does vibration: it is the longest interval of a revolution.
    Between two revolutions with all of their pulses it has lost no tooth beside it, however wide it is.
    """
    from scipy.ndimage import maximum_filter, median_filter

    gap, present = wheel.missing + 1, wheel.pitches - wheel.missing
    steps[(shares > gap) & (shares < gap + WIDER)] = gap
    longest = maximum_filter(shares, present, mode="nearest")
    gaps = np.flatnonzero((shares > gap - 0.5) & (shares == longest))
    if gaps.size < 2:
        return
    whole = np.diff(gaps) == present
    for begin in gaps[:-1][whole].tolist():
        steps[begin + 1 : begin + present] = 1
    before, behind = np.append(False, whole), np.append(whole, False)
    # One with a lost tooth beside it is a pitch wider than its neighbors.
    narrow = shares[gaps] < median_filter(shares[gaps], NEIGHBORS) + 0.5
    steps[gaps[before & behind | (before | behind) & narrow]] = gap


def _by_marks(
    number: Integers, marks: Integers, steps: Integers, wheel: Wheel
) -> tuple[Integers, Flags]:
    """Count pitches from the first mark, and say which pulses are sure.

    Where all pitches between marks are counted, their numbers differ by whole revolutions. A mark that
    disagrees with its neighbors is a tooth that was lost; where all after it disagree, pitches were.
    """
    what = (
        "double tooth"
        if wheel.double
        else "gap of one tooth"
        if wheel.missing == 1
        else f"gap of {wheel.missing} teeth"
    )
    if not marks.size:
        raise _not_this(steps, wheel, f"there is no {what} among {number.size} pulses")
    usual = np.bincount(number[marks] % wheel.pitches).argmax()
    half = wheel.pitches // 2
    shift = (number[marks] - usual + half) % wheel.pitches - half
    agreeing = shift == _usual_nearby(shift)
    marks, shift = marks[agreeing], shift[agreeing]
    turns = (number[-1] - number[0]) / wheel.pitches
    if marks.size < MARKED * (turns - 1.0):
        raise _not_this(
            steps, wheel, f"a {what} is found {marks.size} times in {turns:.0f} revolutions"
        )
    behind = np.searchsorted(marks, np.arange(number.size), side="right")
    last, following = np.maximum(behind - 1, 0), np.minimum(behind, marks.size - 1)
    sure = shift[last] == shift[following]
    counted = number - usual - shift[last]
    return counted - counted[sure][0] // wheel.pitches * wheel.pitches, sure


def _usual_nearby(shift: Integers) -> Integers:
    """Return the most frequent shift of each mark's neighbors; zero, that of most marks, if several are."""
    usual = np.zeros_like(shift)
    for place in range(shift.size):
        values, counts = np.unique(
            shift[max(place - AGREEING, 0) : place + AGREEING + 1], return_counts=True
        )
        most = values[counts == counts.max()]
        usual[place] = 0 if 0 in most else most[0]
    return usual


def _wheel_like(steps: Integers) -> Wheel | None:
    """Return the wheel with a gap that the pulses look like, if they do."""
    long = np.flatnonzero(steps > 1)
    if long.size <= 2:
        return None
    size = int(np.bincount(steps[long]).argmax())
    apart = np.diff(np.flatnonzero(steps == size))
    if not apart.size:
        return None
    usual = int(np.bincount(apart).argmax())
    often = np.count_nonzero(apart == usual) > 0.5 * apart.size
    return Wheel(usual + size - 1, size - 1) if often else None


def _not_this(steps: Integers, wheel: Wheel, why: str) -> InputError:
    """Return the refusal, with the wheel that the pulses look like."""
    like = ""
    if (other := _wheel_like(steps)) not in (None, wheel):
        like = f"; the pulses are like those of a wheel {other}"
    elif not np.any(steps > 1):
        like = "; the pulses are even, as those of a wheel without a mark"
    return InputError(f"teeth: given {wheel}; {why}{like}.")
