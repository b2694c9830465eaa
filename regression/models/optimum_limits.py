"""Limits of an optimum search, applied to the worst value within a model's error band."""

import itertools
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from crankbase.checks.arrays import LARGEST, SMALLEST
from crankbase.checks.choices import did_you_mean
from crankbase.checks.scalars import is_number
from crankbase.errors import InputError
from regression.models.angle import between_values
from regression.models.compliance_model import ComplianceModel
from regression.models.extrapolation import error_band
from regression.response_kinds import ANGLE_LAWS


@dataclass(frozen=True)
class Limit:
    """A bound on a response or dimension of a model, or on a function of some.

    Parameters
    ----------
    quantities : tuple of str
        Responses of the model or dimensions; one, or the arguments of `function`.
    at_most, at_least : float or None
        The bound [SI]; one of the two.
    function : callable, optional
        Takes one float for each quantity, in order, and returns a float, for example a frequency from a
        compliance. It should be monotonic in each of them, since only the ends of their bands
        are tried. By default the quantity itself is limited.
    name : str
        Its name; by default the quantity's.
    unit : str
        SI unit for messages.
    gamma_deg : float, optional
        Angle to the neighbors for the axial compliance or influence coefficient among the quantities.

    Raises
    ------
    InputError
        If not one bound is given, or several quantities without a function.

    Examples
    --------
    ``Limit(("axial_compliance",), at_most=1.2e-9)``
    """

    quantities: tuple[str, ...]
    at_most: float | None = None
    at_least: float | None = None
    function: Callable[..., float] | None = None
    name: str = ""
    unit: str = ""
    gamma_deg: float | None = None

    def __post_init__(self) -> None:
        shown = self.name or ", ".join(self.quantities)
        given = [bound for bound in (self.at_most, self.at_least) if bound is not None]
        if len(given) != 1 or not is_number(given[0]):
            raise InputError(
                f"limit on {shown}: given at most {self.at_most}, at least {self.at_least}; allowed is "
                "one finite bound, because each limit is checked by itself."
            )
        if given[0] != 0.0 and not SMALLEST <= abs(given[0]) <= LARGEST:
            raise InputError(
                f"limit on {shown}: given {given[0]:g}; allowed is zero, or {SMALLEST:g} to {LARGEST:g} of "
                "either sign, because others leave what a computer can calculate."
            )
        if isinstance(self.quantities, str) or not self.quantities:
            raise InputError(
                f"limit: given quantities {self.quantities!r}; allowed is a tuple of names, at least "
                "one."
            )
        if self.function is None and len(self.quantities) != 1:
            raise InputError(
                f"limit on {shown}: given {len(self.quantities)} quantities; allowed is one, or a "
                "function of them."
            )
        if not self.name:
            object.__setattr__(self, "name", shown)

    @property
    def bound(self) -> float:
        """The bound, from above or below."""
        bound = self.at_most if self.at_most is not None else self.at_least
        assert bound is not None
        return bound

    @property
    def sign(self) -> str:
        """The comparison as text."""
        return "<=" if self.at_most is not None else ">="

    def excess(self, values: Any) -> Any:
        """Distance of values beyond the bound, as a share of it; negative where they keep it."""
        size = abs(self.bound) or 1.0
        beyond = (values - self.bound) / size
        return beyond if self.at_most is not None else -beyond


def check_minimized(model: ComplianceModel, name: str, argument: str = "minimize") -> None:
    """Refuse to minimize a name that is not a number of the model.

    Parameters
    ----------
    model : ComplianceModel
    name : str
        A response or dimension.
    argument : str
        Argument of the name, for the message.

    Raises
    ------
    InputError
    """
    if name not in model.responses and name not in model.family.all_units:
        raise _unknown(argument, model, name)


def _unknown(argument: str, model: ComplianceModel, name: str) -> InputError:
    family = model.family
    names = (*family.ranges, *family.relations, *family.fixed)
    meant = did_you_mean(name, (*model.responses, *names))
    return InputError(
        f"{argument}: given {name!r}; {meant}allowed are the responses {', '.join(model.responses)} and the "
        f"dimensions {', '.join(names)}."
    )


@dataclass(frozen=True)
class Points:
    """Throws of a model's family: all its factors, as numbers, labels, or arrays of n values."""

    model: ComplianceModel
    factors: Mapping[str, Any]

    def dimension(self, name: str) -> Any:
        """Value of a factor, a fixed dimension or one that follows from others.

        Raises
        ------
        InputError
            If the model knows no such dimension.
        """
        if name in self.factors:
            return self.factors[name]
        family = self.model.family
        if name in family.fixed:
            return family.fixed[name]
        if name in family.relations:
            return family.completed(self.factors)[name]
        raise _unknown("quantity", self.model, name)

    def band(self, name: str, gamma_deg: float | None = None) -> tuple[Any, ...]:
        """Value of a quantity, and the ends of its error band if it has one.

        Raises
        ------
        InputError
            If the model knows no such quantity, or its band is open on one side.
        """
        if gamma_deg is not None and name in ANGLE_LAWS:
            parts = [self.band(part) for part in self.model.angle_law(name)]
            corners = [between_values(gamma_deg, corner) for corner in itertools.product(*parts)]
            return corners[0], np.min(corners, axis=0), np.max(corners, axis=0)
        if name not in self.model.responses:
            return (self.dimension(name),)
        band = error_band(self.model.responses[name])
        if band.upper is None:
            raise InputError(
                f"{name}: given a model whose error reaches 100 %; allowed is a better one, because "
                "with this no limit can be promised."
            )
        values = self.model.answer(name, self.factors).values
        return values, values * band.lower, values * band.upper


def worst_values(limit: Limit, points: Points, margins: bool) -> Any:
    """Return the worst values of a limit's quantity within the model's error bands.

    Parameters
    ----------
    limit : Limit
    points : Points
    margins : bool
        Whether to use the error bands; otherwise the values by the equations.

    Raises
    ------
    InputError
        If a quantity is unknown or has no band, or a function of it is not finite.
    """
    bands = [points.band(name, limit.gamma_deg) for name in limit.quantities]
    if not margins:
        return _applied(limit, [band[0] for band in bands])
    # The value itself lies between the ends of its band, where it has one.
    ends = [band[1:] or band for band in bands]
    corners = [_applied(limit, list(corner)) for corner in itertools.product(*ends)]
    farthest = np.max if limit.at_most is not None else np.min
    return farthest(corners, axis=0)


def _applied(limit: Limit, values: list[Any]) -> Any:
    if limit.function is None:
        return values[0]
    arrays = np.broadcast_arrays(*values)
    found = np.array(
        [limit.function(*map(float, point)) for point in zip(*map(np.ravel, arrays), strict=True)]
    ).reshape(arrays[0].shape)
    if not np.all(np.isfinite(found)):
        raise InputError(
            f"{limit.name}: given a function that returns {found[~np.isfinite(found)].flat[0]}; "
            "allowed are finite numbers."
        )
    return found
