"""Whether a verdict holds for all possible values of an assumption, and which values decide."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from itertools import groupby, pairwise
from typing import Literal

from crankbase.library_types import DataFrame
from crankbase.summaries import summarized
from crankbase.tables.frames import Row, table_of
from crankbase.units.quantity import format_quantity
from dynamics.assessment.verdict import Status

Acceptance = Literal["acceptable", "not acceptable", "undecided"]


@summarized("field", "value", "unit", "status", "taken")
@dataclass(frozen=True)
class Trial:
    """The verdict with one possible value of an assumption.

    Parameters
    ----------
    field : str
        Field of the value, such as "limits.tensile_strength".
    name : str
        Name of the value, such as "tensile strength".
    value : float
        [unit]
    unit : str
        SI unit.
    status : {"fine", "barred range needed", "not acceptable"}
    taken : bool
        Whether this is the value used in the calculation.
    why : str
        Why another value is possible, if the value is not simply assumed.
    """

    field: str
    name: str
    value: float
    unit: str
    status: Status
    taken: bool = False
    why: str = ""

    @property
    def acceptable(self) -> bool:
        """Whether the engine may run, with barred speeds if necessary."""
        return self.status != "not acceptable"

    @property
    def shown(self) -> str:
        """The value with its unit."""
        return format_quantity(self.value, self.unit, 4)

    def row(self) -> Row:
        """Return the columns of a table of trials, each value with its unit; see `table_of`."""
        return {
            "field": (self.field, ""),
            "value": (self.value, "SI, see the column unit"),
            "unit": (self.unit, ""),
            "status": (self.status, ""),
            "taken": (self.taken, ""),
        }


@summarized("status", "sentence", "trials")
@dataclass(frozen=True)
class Decision:
    """What can be concluded despite the assumptions.

    Parameters
    ----------
    status : {"acceptable", "not acceptable", "undecided"}
        "undecided" if the engine is acceptable with some of the values tried and not with others.
    sentence : str
        What decides, and the fields that give it; empty if no trial changes the verdict.
    trials : tuple of Trial
    """

    status: Acceptance
    sentence: str
    trials: tuple[Trial, ...]

    def to_pandas(self) -> DataFrame:
        """Return a table with a row for each value tried.

        Returns
        -------
        pandas.DataFrame
            Units of the columns in ``attrs["units"]``.

        Raises
        ------
        MissingLibraryError
            If pandas is not installed.
        """
        return table_of(self.trials)


def decide(status: Status, trials: Iterable[Trial]) -> Decision:
    """Compare the verdict with the values used and those with other possible values.

    Parameters
    ----------
    status : {"fine", "barred range needed", "not acceptable"}
        Of the calculation.
    trials : iterable of Trial
        Of one or more fields, each varied separately; the value used is among its values.

    Returns
    -------
    Decision

    Examples
    --------
    >>> steel = ("limits.tensile_strength", "tensile strength")
    >>> decide("not acceptable", [
    ...     Trial(*steel, 440e6, "Pa", "not acceptable", taken=True), Trial(*steel, 590e6, "Pa", "fine")
    ... ]).sentence
    'acceptable with a tensile strength of 590 MPa, not with 440 MPa (assumed): give limits.tensile_strength'
    """
    tried = tuple(trials)
    by_field = [
        sorted((one for one in tried if one.field == field), key=lambda one: one.value)
        for field in dict.fromkeys(one.field for one in tried)
    ]
    accepted = status != "not acceptable"
    flipped = [own for own in by_field if any(one.acceptable != accepted for one in own)]
    if flipped:
        said = [
            f"acceptable with {_values([one.acceptable for one in own], own)}" for own in flipped
        ]
        return Decision("undecided", "; ".join(said), tried)
    if not accepted:
        return Decision("not acceptable", "", tried)
    barred = [own for own in by_field if any(one.status != status for one in own)]
    said = [
        f"no speeds need be barred with {_values([one.status == 'fine' for one in own], own)}"
        for own in barred
    ]
    return Decision("acceptable", "; ".join(said), tried)


def _values(kept: Sequence[bool], trials: Sequence[Trial]) -> str:
    """State with which values something holds and with which it does not: the two on either side."""
    runs = [list(own) for _, own in groupby(zip(kept, trials, strict=True), key=lambda one: one[0])]
    if len(runs) == 2:
        ends = dict(own for runs_own in (runs[0][-1:], runs[1][:1]) for own in runs_own)
        shown = {holds: _shown(one) for holds, one in ends.items()}
    else:
        shown = {
            holds: " or ".join(
                _shown(one) for own, one in zip(kept, trials, strict=True) if own == holds
            )
            for holds in (True, False)
        }
    first = trials[0]
    taken = [one for one in trials if one.taken]
    word = _word(first)
    told = f"{word})" in "".join(shown.values())
    beside = "" if told or not taken else f" ({taken[0].shown} {word})"
    remedy = f"within {first.why}, set by" if first.why else "give"
    article = "an" if first.name[0] in "aeiou" else "a"
    return f"{article} {first.name} of {shown[True]}, not with {shown[False]}{beside}: {remedy} {first.field}"


def _shown(trial: Trial) -> str:
    return f"{trial.shown} ({_word(trial)})" if trial.taken else trial.shown


def _word(trial: Trial) -> str:
    """Label of the value used."""
    return "used" if trial.why else "assumed"


def changes(trials: Sequence[Trial]) -> list[tuple[Trial, Trial]]:
    """Return the adjacent values between which the engine becomes acceptable, or stops being so."""
    ordered = sorted(trials, key=lambda one: one.value)
    return [pair for pair in pairwise(ordered) if pair[0].acceptable != pair[1].acceptable]
