"""Groups of a chain's values that move together in a calibration, with their tolerances."""

import math
import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple, cast

import numpy as np

from crankbase.array_checks import Array
from crankbase.choices import allowed_names
from crankbase.errors import InputError, quoted
from dynamics.assessment.uncertainty import (
    ALL_DAMPING,
    DAMPINGS,
    FIELDS,
    Kind,
    Spread,
    spread_indices,
)
from dynamics.chains.chain import Chain

# A maker's tolerance of 5 % is taken as 95 of 100 parts within it: two standard deviations.
DEVIATIONS_OF_TOLERANCE = 2.0
LEAST_TOLERANCE, LARGEST_TOLERANCE = 1e-4, 20.0
# Beside the fields of a chain: the factor on modal damping, and on each source of excitation.
MODAL, EXCITATION = "modal", "excitation"
OF_CHAIN = tuple(dict.fromkeys(field for field, _ in FIELDS.values()))
# Change by which a field's part in a value is found, and what is no part or not linear beyond it.
PROBE, ROUND_OFF = 1e-2, 1e-9
PERCENT = re.compile(r"(.+?)\s*=\s*([0-9.]+)\s*(%?)")


class Act(NamedTuple):
    """What a group does to one kind of value: to a share of each, by a power of its factor."""

    field: str
    shares: Array
    power: int


@dataclass(frozen=True, eq=False)
class Group:
    """Values that have one factor, whose logarithm is normal about zero before the measurement.

    Parameters
    ----------
    name : str
    acts : tuple of Act
    deviation : float
        Standard deviation of the logarithm of the factor.
    field : str
        Of the engine file, if the group is one.
    """

    name: str
    acts: tuple[Act, ...]
    deviation: float
    field: str = ""

    @property
    def tolerance(self) -> float:
        """Share by which the maker's value may be off, 95 of 100 times."""
        return math.expm1(DEVIATIONS_OF_TOLERANCE * self.deviation)


def deviation_of(name: str, tolerance: float) -> float:
    """Return the standard deviation of a factor's logarithm from a tolerance as a share.

    Raises
    ------
    InputError
        If the tolerance is not a positive share.
    """
    if not LEAST_TOLERANCE <= tolerance <= LARGEST_TOLERANCE:
        raise InputError(
            f"{name}: given a tolerance of {tolerance:g}; allowed is a share from {LEAST_TOLERANCE:g} to "
            f"{LARGEST_TOLERANCE:g}, such as 0.05 for 5 %, because a value that cannot move is not fitted."
        )
    return math.log1p(tolerance) / DEVIATIONS_OF_TOLERANCE


def group_of_spread(chain: Chain, spread: Spread, field: str = "") -> Group:
    """Return the group of a spread; the ends of its range are taken as two standard deviations."""
    ends = np.abs(np.log([spread.low, spread.high]))
    deviation = deviation_of(spread.name, float(np.expm1(np.max(ends))))
    if spread.kind == ALL_DAMPING:
        sizes = {name: len(getattr(chain, name)) for name in DAMPINGS} | {MODAL: 1}
        acts = tuple(Act(name, np.ones(size), 1) for name, size in sizes.items())
        return Group(spread.name, acts, deviation, field)
    name, power = FIELDS[spread.kind]
    shares = np.zeros(len(getattr(chain, name)))
    shares[spread_indices(chain, spread)] = 1.0
    if not np.any(shares * values_of(chain)[name]):
        raise InputError(
            f"{spread.name}: given, where the chain has none; allowed are values above zero, because a "
            "factor on zero moves nothing."
        )
    return Group(spread.name, (Act(name, shares, power),), deviation, field)


def chain_group(chain: Chain, name: str, tolerance: float) -> Group:
    """Return the group named "KIND" or "KIND of PLACE, PLACE", such as "inertia of flywheel".

    Raises
    ------
    InputError
        If the kind or a place is unknown, or the tolerance out of range.
    """
    kind, _, places = name.partition(" of ")
    kinds = [*FIELDS, ALL_DAMPING]
    if kind not in kinds:
        raise InputError(f"{name}: unknown group; {allowed_names(kind, kinds)}.")
    factor = math.exp(DEVIATIONS_OF_TOLERANCE * deviation_of(name, tolerance))
    at = tuple(place.strip() for place in places.split(",")) if places else None
    return group_of_spread(chain, Spread(cast(Kind, kind), 1.0 / factor, factor, at, name))


def excitation_group(name: str, sources: int, places: Sequence[int], tolerance: float) -> Group:
    """Return the group of a gain of some sources of excitation, such as cylinders, by number from 0."""
    shares = np.zeros(sources)
    shares[list(places)] = 1.0
    return Group(name, (Act(EXCITATION, shares, 1),), deviation_of(name, tolerance))


def field_group(
    field: str, tolerance: float, chain_at: Callable[[float], tuple[Chain, float]]
) -> Group:
    """Return the group of a field of a file, from the chains that it makes.

    Parameters
    ----------
    chain_at : callable
        Chain and modal damping, as a share of critical, with the field multiplied by a factor.

    Raises
    ------
    InputError
        If the chain does not depend on it, or not linearly: then it is no factor on its values.
    """
    low, middle, high = (
        values_of(chain) | {MODAL: np.array([damping])}
        for chain, damping in (chain_at(1.0 - PROBE), chain_at(1.0), chain_at(1.0 + PROBE))
    )
    acts = []
    for name, value in middle.items():
        scale = np.where(value == 0.0, 1.0, value)
        for power in (1, -1):
            ends = (1.0 - PROBE) ** power, (1.0 + PROBE) ** power
            shares = (high[name] - low[name]) / (ends[1] - ends[0]) / scale
            bent = (high[name] - value) / scale - shares * (ends[1] - 1.0)
            if np.max(np.abs(bent), initial=0.0) <= ROUND_OFF:
                if np.any(np.abs(shares) > ROUND_OFF):
                    acts.append(Act(name, np.where(np.abs(shares) > ROUND_OFF, shares, 0.0), power))
                break
        else:
            raise InputError(
                f"{field}: given as a group; allowed are fields that are a factor on values of the torsional "
                "chain, because the slopes are those of such factors."
            )
    if not acts:
        raise InputError(
            f"{field}: given as a group; allowed are fields on which the torsional chain depends, because "
            "the records say nothing on others."
        )
    return Group(field, tuple(acts), deviation_of(field, tolerance), field)


def parsed_group(text: str) -> tuple[str, float]:
    """Return name and tolerance of "NAME=5%" or "NAME=0.05".

    Raises
    ------
    InputError
        If the text is another.
    """
    match = PERCENT.fullmatch(text.strip())
    try:
        assert match is not None
        return match[1], float(match[2]) * (0.01 if match[3] else 1.0)
    except (AssertionError, ValueError):
        raise InputError(
            f"--move: given {quoted(text)}; allowed is a group and its tolerance, like flywheel.inertia=5%, "
            "because what may move needs a measure of how far."
        ) from None


def values_of(chain: Chain) -> dict[str, Array]:
    """Return the values of a chain that groups act on."""
    values = {name: getattr(chain, name) for name in OF_CHAIN if name != "dashpots"}
    return values | {"dashpots": np.array([each.damping for each in chain.dashpots])}


@dataclass(frozen=True, eq=False)
class MovedValues:
    """Values under factors, and their slopes to the groups' parameters.

    Attributes
    ----------
    values : dict
        Field to its values (size,).
    slopes : dict
        Field to d value / d parameter, (p, size); a parameter is the logarithm of a factor in standard
        deviations.
    """

    values: dict[str, Array]
    slopes: dict[str, Array]


def moved_values(
    nominal: Mapping[str, Array], groups: Sequence[Group], parameters: Array
) -> MovedValues:
    """Return the values at parameters (p,); a value of several groups has all of their factors."""
    values = {name: value.copy() for name, value in nominal.items()}
    rates = {name: np.zeros((len(groups), value.size)) for name, value in nominal.items()}
    for number, group in enumerate(groups):
        for field, shares, power in group.acts:
            factor = math.exp(power * group.deviation * float(parameters[number]))
            scale = 1.0 + shares * (factor - 1.0)
            values[field] *= scale
            rates[field][number] += power * group.deviation * shares * factor / scale
    return MovedValues(values, {name: rates[name] * values[name] for name in values})
