"""Permitted vibration over the speed: limits with their source, given or from rules."""

from collections.abc import Callable, Sequence
from functools import cached_property, partial
from typing import Annotated

import numpy as np
from numpy.typing import ArrayLike

from crankbase.array_checks import (
    Array,
    nonnegative_number,
    positive_number,
    positive_vector,
    read_only,
)
from crankbase.choices import check_some
from crankbase.errors import InputError
from crankbase.results import InItsUnit, Internal, Number, Quantity, Result, Speed, result
from crankbase.sentences import in_si
from dynamics.indices import within

Values = Callable[[Array], Array]


@result("low [rad/s]", "high [rad/s]")
class LimitCurve:
    """A permitted value over the speed, within the range of speeds for which it is stated.

    Parameters
    ----------
    values : callable
        Speeds (S,) [rad/s] to permitted values (S,).
    low, high : float
        First and last speed for which the value is stated [rad/s], both included; all by default.

    Raises
    ------
    InputError
        If `low` is negative, or not below `high`.
    """

    values: Values
    low: float = 0.0
    high: float = np.inf

    def __post_init__(self) -> None:
        low = nonnegative_number("low", self.low, "rad/s", "the limit is stated from there")
        if self.high == np.inf:
            return
        if not positive_number("high", self.high, "rad/s", "the limit is stated up to there") > low:
            raise InputError(
                f"high: given {in_si(self.high, 'rad/s')}; allowed is more than the {in_si(low, 'rad/s')} of "
                "low, because the limit is stated between them."
            )

    def at(self, speeds: Array) -> Array:
        """Return the permitted values (S,); inf at speeds for which none is stated."""
        stated = within(speeds, self.low, self.high)
        # A rule's formula may mean nothing outside its range, so it is not asked there.
        permitted = np.full(speeds.shape, np.inf)
        permitted[stated] = self.values(speeds[stated])
        return permitted


@result(
    "quantity",
    "applies_to",
    "unit",
    "continuous.low [rad/s]",
    "continuous.high [rad/s]",
    "source",
    "assumed",
    "remark",
)
class VibrationLimit(Result):
    """The permitted value of a quantity in continuous running and while a barred range is passed.

    Parameters
    ----------
    quantity : str
        What is limited, such as "torsional stress".
    applies_to : str
        Where, for example "crankshaft" or "free end".
    unit : str
        SI unit of the values: Pa, N m, N, rad or m.
    continuous : LimitCurve
        Permitted amplitude in continuous running.
    source : str
        Source of the value, in words.
    passing : LimitCurve or None
        Permitted amplitude at speeds that are only passed quickly; above its range nothing may be
        barred. None if the source has none.
    assumed : bool
        Whether the value is typical or derived, not given by anybody.
    remark : str
        Further requirements of the source.
    misfiring_basis : str
        What says that the permitted amplitude in passing serves while a cylinder misfires; empty where
        nothing does.
    """

    quantity: Internal[str]
    applies_to: Internal[str]
    unit: str
    continuous: Internal[LimitCurve]
    source: str
    passing: Internal[LimitCurve | None] = None
    assumed: bool = False
    remark: Internal[str] = ""
    misfiring_basis: Internal[str] = ""

    def __post_init__(self) -> None:
        if not self.source.strip():
            raise InputError(
                f"limit on {self.name}: given no source; allowed is a sentence that says where the "
                "value comes from, because a verdict depends on its limits."
            )

    @cached_property
    def name(self) -> Annotated[str, Quantity(key="limit")]:
        """Quantity and place, such as "torsional stress of crankshaft"."""
        return f"{self.quantity} of {self.applies_to}"

    @property
    def misfiring(self) -> LimitCurve:
        """Permitted while a cylinder misfires: that for running, unless `misfiring_basis` says otherwise."""
        if self.passing is None or not self.misfiring_basis:
            return self.continuous
        kept, passed = self.continuous, self.passing
        low, high = min(kept.low, passed.low), max(kept.high, passed.high)
        return LimitCurve(partial(_first_stated, passed, kept), low, high)


def _first_stated(first: LimitCurve, other: LimitCurve, speeds: Array) -> Array:
    values = first.at(speeds)
    return np.where(np.isfinite(values), values, other.at(speeds))


def given_limit(
    quantity: str,
    value: float,
    unit: str,
    *,
    applies_to: str,
    source: str,
    passing: float | None = None,
    assumed: bool = False,
) -> VibrationLimit:
    """Make a limit that is the same at all speeds, as engine makers give them.

    Parameters
    ----------
    quantity, unit, applies_to, source, assumed
        As in `VibrationLimit`.
    value : float
        Permitted amplitude (half of the range from lowest to highest) [unit].
    passing : float, optional
        Permitted amplitude while a barred range is passed [unit]; not below `value`.

    Raises
    ------
    InputError
        If a value is not above zero, `passing` is less than `value`, or the source is missing.

    Examples
    --------
    >>> limit = given_limit("axial amplitude", 0.4e-3, "m", applies_to="free end", source="maker")
    >>> limit.continuous.at(np.array([10.0, 20.0])).tolist()
    [0.0004, 0.0004]
    """
    field = f"limit on {quantity} of {applies_to}"
    kept = positive_number(field, value, unit, "every engine vibrates")
    passed = None
    if passing is not None:
        passed = positive_number(field, passing, unit, "every engine vibrates")
    if passed is not None and passed < kept:
        raise InputError(
            f"{field}: given {passed:g} {unit} while a barred range is passed; allowed are finite numbers of "
            f"{kept:g} {unit} or more, because a permitted continuous vibration may also be passed."
        )
    return VibrationLimit(
        quantity=quantity,
        applies_to=applies_to,
        unit=unit,
        continuous=constant_curve(kept),
        passing=None if passed is None else constant_curve(passed),
        source=source,
        assumed=assumed,
    )


def constant_curve(value: float, low: float = 0.0, high: float = np.inf) -> LimitCurve:
    """Return a curve of one value between two speeds [rad/s]."""
    return LimitCurve(partial(_constant, value), low, high)


def _constant(value: float, speeds: Array) -> Array:
    return np.full(speeds.shape, value)


@result("name", "speeds [rad/s]", "peak")
class AmplitudeCurve:
    """An amplitude over the speed, for comparison with a limit.

    Parameters
    ----------
    name : str
        Location, for example "shaft cylinder 5 - cylinder 6".
    speeds : array_like of shape (S,)
        Ascending [rad/s].
    values : array_like of shape (S,)
        Amplitudes in the SI unit of the limit; inf where the vibration is unbounded.

    Raises
    ------
    InputError
        If speeds do not ascend, lengths differ, or a value is negative or not a number.
    """

    name: str
    speeds: Array
    values: Array

    def __init__(self, name: str, speeds: ArrayLike, values: ArrayLike) -> None:
        places = positive_vector("speeds", speeds, "rad/s", "a limit holds for a turning shaft")
        if places.size == 0 or not np.all(np.diff(places) > 0.0):
            raise InputError(
                f"speeds of {name}: given {places.size} values that do not ascend; allowed are one or "
                "more, each above the last, because ranges of speeds are searched among them."
            )
        sizes = np.array(values, dtype=np.float64)
        if sizes.shape != places.shape or np.any(np.isnan(sizes)) or np.any(sizes < 0.0):
            raise InputError(
                f"values of {name}: given an array of shape {sizes.shape} for {places.size} speeds; allowed "
                "is an amplitude of zero or more (inf if unbounded) at each speed, because each is compared "
                "with its limit."
            )
        object.__setattr__(self, "name", name)
        object.__setattr__(self, "speeds", read_only(places))
        object.__setattr__(self, "values", read_only(sizes))

    @property
    def peak(self) -> float:
        """Largest value."""
        return float(np.max(self.values))


def usage(limit: VibrationLimit, curve: AmplitudeCurve) -> Array:
    """Return the share of the permitted amplitude that is used at each speed, (S,).

    Returns
    -------
    ndarray of shape (S,)
        Value over permitted value: above 1 where the limit is exceeded, inf where the vibration is
        unbounded, 0 at speeds without a stated limit.
    """
    permitted = limit.continuous.at(curve.speeds)
    stated = np.isfinite(permitted)
    shares = np.zeros(curve.speeds.shape)
    np.divide(curve.values, permitted, out=shares, where=stated)
    return shares


@result("speed", "value", "permitted", "used")
class LimitUse(Result):
    """The largest use of a limit among some speeds, in the unit of the limit."""

    speed: Speed
    value: InItsUnit
    permitted: InItsUnit

    @cached_property
    def used(self) -> Number:
        """Share of the permitted value."""
        return self.value / self.permitted


def worst_use(
    limit: VibrationLimit, curve: AmplitudeCurve, low: float, high: float
) -> LimitUse | None:
    """Return the largest use between speeds [rad/s], if any."""
    permitted = limit.continuous.at(curve.speeds)
    some = np.isfinite(permitted) & within(curve.speeds, low, high)
    if not np.any(some):
        return None
    worst = int(np.argmax(np.where(some, usage(limit, curve), -np.inf)))
    return LimitUse(*(float(each[worst]) for each in (curve.speeds, curve.values, permitted)))


def axial_force_limit(
    permissible_stress: float,
    crank_radius: float,
    web_width: float,
    web_thickness: float,
    *,
    source: str,
) -> VibrationLimit:
    """Derive a limit on the axial force through the throws from a permitted alternating stress.

    Parameters
    ----------
    permissible_stress : float
        Permitted amplitude of the nominal stress in a web [Pa], without the stress concentration of fillets.
    crank_radius, web_width, web_thickness : float
        [m].
    source : str
        Of the permissible stress.

    Returns
    -------
    VibrationLimit
        Of the axial force [N], marked assumed: it is derived, not stated by the source.

    Raises
    ------
    InputError
        If a value is not above zero.

    Notes
    -----
    A force F along the axis of the main journals acts on the crankpin with the crank radius R as
    lever. In a throw whose ends tilt freely (pinned), the web next to the pin carries the
    bending moment F R and the force F itself, so that its nominal stress is
    F (6 R / (B h^2) + 1 / (B h)). Ends that are hindered from tilting reduce the moment: the limit
    is conservative.
    """
    stress, radius, width, thickness = (
        positive_number(name, value, unit, "it is that of a crankshaft")
        for name, value, unit in (
            ("permissible_stress", permissible_stress, "Pa"),
            ("crank_radius", crank_radius, "m"),
            ("web_width", web_width, "m"),
            ("web_thickness", web_thickness, "m"),
        )
    )
    area = width * thickness
    per_force = 6.0 * radius / (area * thickness) + 1.0 / area
    return given_limit(
        "axial force",
        stress / per_force,
        "N",
        applies_to="throws",
        source=f"derived from a permitted nominal stress of {stress / 1e6:g} MPa in the webs of a "
        f"pinned throw; {source}",
        assumed=True,
    )


def checked_running_range(running_range: tuple[float, float]) -> tuple[float, float]:
    """Return the lowest and the highest running speed [rad/s]."""
    allowed = (
        "the lowest and then the highest running speed, because limits and margins refer to both"
    )
    of = "it is that of a turning engine"
    return positive_range("running_range", running_range, "rad/s", of, allowed)


def positive_range(
    field: str, ends: ArrayLike, unit: str, of: str, allowed: str
) -> tuple[float, float]:
    """Return the ends of a range of positive values, which may be equal; `of` says why they are positive."""
    pair = positive_vector(field, ends, unit, of)
    if pair.size != 2 or not pair[0] <= pair[1]:
        shown = ", ".join(f"{end:g}" for end in pair)
        raise InputError(f"{field}: given ({shown}) {unit}; allowed are {allowed}.")
    return float(pair[0]), float(pair[1])


def checked_rated_speed(rated_speed: float) -> float:
    """Return the rated speed [rad/s]."""
    return positive_number(
        "rated_speed", rated_speed, "rad/s", "limits are stated for shares of it"
    )


def check_findings(findings: Sequence[tuple[VibrationLimit, AmplitudeCurve]]) -> None:
    """Refuse findings that are not pairs of a limit and an amplitude curve."""
    check_some("findings", findings, "a verdict needs a limit and an amplitude to hold against it")
    for place, pair in enumerate(findings):
        if tuple(map(type, pair)) != (VibrationLimit, AmplitudeCurve):
            raise InputError(
                f"findings[{place}]: given {', '.join(type(one).__name__ for one in pair) or 'none'}; "
                "allowed is a VibrationLimit and an AmplitudeCurve, because one is held against the other."
            )
