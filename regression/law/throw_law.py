"""The law: axial and torsional compliances of throws from their dimensions alone, with error bands.

Networks trained on finite elements of thousands of throws (docs/law.md) give dimensionless
compliances; E and the size are exact factors, Poisson's ratio near 0.3 has its mean effect. End sections are
rigid discs, as in `fem.analysis.analyze_throw`; counterweights hardly stiffen a throw and are neglected.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from crankbase.array_checks import finite_array
from crankbase.choices import is_number
from crankbase.errors import InputError, quoted
from crankbase.summaries import summarized
from geometry.throw import CrankThrow
from regression.formulas.case import check_youngs_modulus
from regression.law.networks import TIERS, networks, plain_inputs, real_inputs
from regression.law.ratios import (
    FADES,
    LENGTH_FADES,
    MORE_FIELDS,
    PLAIN_FIELDS,
    RANGES,
    Ratios,
    check_range,
    is_plain,
    nearest_plain,
    plain_share,
    ratio_text,
    ratios,
    throw_dimensions,
)
from regression.models.angle import between_values

Array = NDArray[np.float64]

POISSON_RATIO = 0.3
POISSON_RANGE = (0.25, 0.35)
INPUTS = {"plain": plain_inputs, "real": real_inputs}


@summarized("pinned [m/N]", "guided [m/N]", "ratio", "influence_pinned [m/N]", "band [m/N]", "tier")
@dataclass(frozen=True)
class AxialLaw:
    """Axial compliance and influence coefficient by the law: floats for a throw, arrays for many.

    Attributes
    ----------
    pinned, guided : float or ndarray
        e_n, ends pinned and guided [m/N]; between equal neighbors at 180 and at 0 deg.
    ratio : float or ndarray
        rho of the angle law, stiffness against tilting across the crank plane divided by that in it.
    influence_pinned, influence_guided : float or ndarray
        c of P = c Z / e_n [m/N].
    errors : mapping
        Relative half widths of bands that hold the true value in 95 of 100 throws, by the names above.
    tier : str or ndarray
        "plain" or "real": whether the throw is a plain one; between them values pass over continuously.
    nearest_limit : str
        For one throw: the ratio nearest to an end of the law's range, in words.
    """

    pinned: Any
    guided: Any
    ratio: Any
    influence_pinned: Any
    influence_guided: Any
    errors: Mapping[str, Any]
    tier: Any
    nearest_limit: str = ""

    @property
    def band(self) -> tuple[Any, Any]:
        """Ends of the band of `pinned` that holds the true value in 95 of 100 throws [m/N]."""
        return _band(self.pinned, self.errors["pinned"])

    def axial(self, gamma_deg: ArrayLike) -> Any:
        """Axial compliance between equal neighbors at an angle, e(gamma) [m/N].

        Parameters
        ----------
        gamma_deg : float or array_like
            Angle between neighboring cranks [deg].

        Raises
        ------
        InputError
            If an angle is not a finite number, or the shapes do not fit each other.
        """
        return between_values(gamma_deg, (self.guided, self.pinned, self.ratio))

    def influence(self, gamma_deg: ArrayLike) -> Any:
        """Influence coefficient between equal neighbors, c(gamma) [m/N]; as `axial`."""
        return between_values(gamma_deg, (self.influence_guided, self.influence_pinned, self.ratio))


@summarized("pinned [rad/(N m)]", "guided [rad/(N m)]", "band [rad/(N m)]", "tier")
@dataclass(frozen=True)
class TorsionalLaw:
    """Torsional compliance by the law: floats for a throw, arrays for many.

    Attributes
    ----------
    pinned, guided : float or ndarray
        Twist per torque [rad/(N m)].
    errors, tier, nearest_limit
        As of an `AxialLaw`.
    """

    pinned: Any
    guided: Any
    errors: Mapping[str, Any]
    tier: Any
    nearest_limit: str = ""

    @property
    def band(self) -> tuple[Any, Any]:
        """Ends of the band of `pinned` that holds the true value in 95 of 100 throws."""
        return _band(self.pinned, self.errors["pinned"])


# Names of results, with their networks and powers of D beside E.
AXIAL = {
    "pinned": ("axial_pinned", 1),
    "guided": ("axial_guided", 1),
    "ratio": ("tilt_ratio", 0),
    "influence_pinned": ("influence_pinned", 1),
    "influence_guided": ("influence_guided", 1),
}
TORSIONAL = {"pinned": ("torsional_pinned", 3), "guided": ("torsional_guided", 3)}


def axial_law(
    throw: CrankThrow, *, youngs_modulus: float = 2.1e11, poisson_ratio: float = POISSON_RATIO
) -> AxialLaw:
    """Axial compliance and influence coefficient of a throw by the law.

    Parameters
    ----------
    youngs_modulus : float
        E [Pa].
    poisson_ratio : float
        0.25 to 0.35; the networks are trained at 0.3 and corrected by the mean effect.

    Raises
    ------
    InputError
        If a ratio of the throw is outside the range of the law's training throws, or the
        throw has features that they lack.

    Examples
    --------
    >>> throw = CrankThrow(
    ...     crank_radius=0.170, main_journal_diameter=0.220, pin_diameter=0.180,
    ...     main_journal_length=0.120, pin_length=0.139, web_width=0.300, web_thickness=0.068,
    ...     fillet_radius=0.012,
    ... )
    >>> print(f"{axial_law(throw).pinned:.2e} m/N")
    1.28e-09 m/N
    """
    answers = LawAnswers.of_throw(throw, youngs_modulus, poisson_ratio)
    return AxialLaw(**answers.results(AXIAL)[0])


def torsional_law(
    throw: CrankThrow, *, youngs_modulus: float = 2.1e11, poisson_ratio: float = POISSON_RATIO
) -> TorsionalLaw:
    """Torsional compliance of a throw by the law; parameters and errors as `axial_law`."""
    answers = LawAnswers.of_throw(throw, youngs_modulus, poisson_ratio)
    return TorsionalLaw(**answers.results(TORSIONAL)[0])


def throw_laws(
    throw: CrankThrow, *, youngs_modulus: float = 2.1e11, poisson_ratio: float = POISSON_RATIO
) -> tuple[AxialLaw, TorsionalLaw]:
    """Both laws of a throw in the time of one; parameters and errors as `axial_law`."""
    answers = LawAnswers.of_throw(throw, youngs_modulus, poisson_ratio)
    axial, torsional = answers.results(AXIAL, TORSIONAL)
    return AxialLaw(**axial), TorsionalLaw(**torsional)


def axial_laws(
    *, youngs_modulus: float = 2.1e11, poisson_ratio: float = POISSON_RATIO, **dimensions: ArrayLike
) -> AxialLaw:
    """Axial compliance and influence coefficient of many throws by the law.

    Parameters
    ----------
    youngs_modulus, poisson_ratio
        As for `axial_law`.
    **dimensions : array_like
        Fields of `CrankThrow` [m] that can be broadcast together: the first eight, and of the others
        fillets, bores with their offsets, and the webs' ends, corners, tips and feet. Whether such
        throws can be built is not checked.

    Raises
    ------
    InputError
        If a dimension is missing, unknown or not an array of finite numbers, or a ratio is outside.

    Examples
    --------
    >>> law = axial_laws(
    ...     crank_radius=0.170, main_journal_diameter=0.220, pin_diameter=0.180,
    ...     main_journal_length=0.120, pin_length=0.139, web_width=0.300,
    ...     web_thickness=[0.050, 0.068, 0.090], fillet_radius=0.012,
    ... )
    >>> law.pinned.shape
    (3,)
    """
    answers = LawAnswers(_given(dimensions), youngs_modulus, poisson_ratio)
    return AxialLaw(**answers.results(AXIAL)[0])


def torsional_laws(
    *, youngs_modulus: float = 2.1e11, poisson_ratio: float = POISSON_RATIO, **dimensions: ArrayLike
) -> TorsionalLaw:
    """Torsional compliance of many throws by the law; parameters and errors as `axial_laws`."""
    answers = LawAnswers(_given(dimensions), youngs_modulus, poisson_ratio)
    return TorsionalLaw(**answers.results(TORSIONAL)[0])


class LawAnswers:
    """Outputs for throws of some dimensions, each by the networks of its tier."""

    def __init__(
        self, dimensions: Mapping[str, Any], youngs_modulus: float, poisson_ratio: float
    ) -> None:
        check_material(youngs_modulus, poisson_ratio)
        self.ratios = ratios(dimensions)
        self.plain = is_plain(self.ratios)
        if self.plain is not True:  # a plain throw is within the range
            check_range(self.ratios)
        self.modulus, self.beside = youngs_modulus, poisson_ratio - POISSON_RATIO
        self.diameter = dimensions["main_journal_diameter"]
        shapes = {value.shape for value in self.ratios.values() if isinstance(value, np.ndarray)}
        self.shape = np.broadcast_shapes(*shapes) if shapes else ()

    @classmethod
    def of_throw(
        cls, throw: CrankThrow, youngs_modulus: float, poisson_ratio: float
    ) -> "LawAnswers":
        """Outputs for one throw; errors as of `axial_law`."""
        return cls(throw_dimensions(throw), youngs_modulus, poisson_ratio)

    @property
    def tier(self) -> Any:
        """Whether throws are "plain" or "real", an array of these for many."""
        return np.where(self.plain, *TIERS) if self.shape else TIERS[not self.plain]

    def values(self, names: tuple[str, ...]) -> tuple[Array, Array]:
        """Dimensionless outputs (k, ...) by the names of `OUTPUTS`, and relative half widths."""
        shape = self.shape or (1,)
        if not self.shape:
            answers, widths = (_of_plain if self.plain else _of_real)(names, self.ratios, shape)
        else:
            plain = np.broadcast_to(self.plain, shape).ravel()
            answers, widths = np.empty((2, len(names), plain.size))
            for answer, where in ((_of_plain, plain), (_of_real, ~plain)):
                if where.all():
                    answers, widths = answer(names, self.ratios, shape)
                elif where.any():
                    some = _picked(self.ratios, shape, where)
                    answers[:, where], widths[:, where] = answer(names, some, (where.sum(),))
        if self.beside:
            mean, spread = networks("real", names).poisson.T[:, :, None]
            answers = answers * np.exp(mean * self.beside)
            widths = widths + 2.0 * spread * abs(self.beside)
        return answers.reshape(-1, *shape), widths.reshape(-1, *shape)

    def results(self, *kinds: Mapping[str, tuple[str, int]]) -> list[dict[str, Any]]:
        """Fields of each law: values in SI units, errors, tier and the nearest limit."""
        values, widths = self.values(tuple([name for kind in kinds for name, _ in kind.values()]))
        every, errors = (
            iter(rows if self.shape else rows[:, 0].tolist()) for rows in (values, widths)
        )
        nearest = "" if self.shape else _nearest(self.ratios)
        shared = {"tier": self.tier, "nearest_limit": nearest}
        return [
            {
                name: next(every) / (self.modulus * self.diameter**power if power else 1.0)
                for name, (_, power) in kind.items()
            }
            | {"errors": {name: next(errors) for name in kind}}
            | shared
            for kind in kinds
        ]


def _of_plain(
    names: tuple[str, ...], of_throw: Ratios, shape: tuple[int, ...]
) -> tuple[Array, Array]:
    """Outputs (k, n) for ratios of n throws of a shape, and half widths, by the networks of plain throws."""
    return _of_tier("plain", names, of_throw, shape)


def _of_real(
    names: tuple[str, ...], of_throw: Ratios, shape: tuple[int, ...]
) -> tuple[Array, Array]:
    """The same by the networks of real throws, corrected by what these miss of plain ones nearby."""
    answers, widths = _of_tier("real", names, of_throw, shape)
    plain = nearest_plain(of_throw)
    share = plain_share(of_throw, plain, FADES)
    if type(share) is float and share == 0.0:
        return answers, widths
    close: Any = slice(None)
    if type(share) is not float:
        close = np.broadcast_to(share, shape).ravel() > 0.0
        if not close.any():
            return answers, widths
        of_throw, plain = (_picked(some, shape, close) for some in (of_throw, plain))
        share, shape = plain_share(of_throw, plain, FADES), (close.sum(),)
    known, least = _of_tier("plain", names, plain, shape)
    answers[:, close] *= (known / _of_tier("real", names, plain, shape)[0]) ** share
    share = share * plain_share(of_throw, plain, LENGTH_FADES)
    widths[:, close] = share * least + (1.0 - share) * widths[:, close]
    return answers, widths


def _of_tier(
    tier: str, names: tuple[str, ...], of_throw: Ratios, shape: tuple[int, ...]
) -> tuple[Array, Array]:
    some, count = networks(tier, names), math.prod(shape)
    inputs = INPUTS[tier](of_throw).reshape(len(some.low), -1)
    if inputs.shape[1] != count:
        inputs = np.repeat(inputs, count, axis=1)
    return some.evaluate(inputs)


def _picked(of_throw: Ratios, shape: tuple[int, ...], where: NDArray[np.bool_]) -> dict[str, Any]:
    """Ratios of some throws of a shape, flat."""
    return {name: np.broadcast_to(value, shape).ravel()[where] for name, value in of_throw.items()}


def check_material(youngs_modulus: float, poisson_ratio: float) -> None:
    """Refuse an invalid Young's modulus, and a Poisson's ratio outside the law (`InputError`)."""
    check_youngs_modulus(youngs_modulus)
    low, high = POISSON_RANGE
    if not (is_number(poisson_ratio) and low <= poisson_ratio <= high):
        raise InputError(
            f"poisson_ratio: given {quoted(poisson_ratio)}; allowed for the law is {low:g} to {high:g}, "
            "because its training throws have 0.3."
        )


def _given(dimensions: Mapping[str, ArrayLike]) -> dict[str, Any]:
    """Dimensions of many throws, checked."""
    known = (*PLAIN_FIELDS, *MORE_FIELDS)
    for name in dimensions:
        if name not in known:
            raise InputError(f"{name}: not a dimension of the law; allowed are {', '.join(known)}.")
    for name in PLAIN_FIELDS:
        if name not in dimensions and name != "fillet_radius":
            raise InputError(f"{name}: missing; it must be given, because the law needs its ratio.")
    checked: dict[str, Any] = {
        name: finite_array(name, value) for name, value in dimensions.items() if value is not None
    }
    for name in PLAIN_FIELDS:
        if name in checked and not np.all(checked[name] > 0.0):
            raise InputError(
                f"{name}: given {float(np.min(checked[name])):g}; allowed is a positive length in m."
            )
    for name, value in checked.items():
        if value.size == 0:
            raise InputError(
                f"{name}: given no values; allowed is one for each throw, or one for all."
            )
    try:
        np.broadcast_shapes(*(value.shape for value in checked.values()))
    except ValueError:
        shapes = ", ".join(
            f"{name} {value.shape}" for name, value in checked.items() if value.shape
        )
        raise InputError(
            f"dimensions: given arrays of the shapes {shapes}; allowed are shapes that can be broadcast "
            "together."
        ) from None
    return checked


def _nearest(shape: Mapping[str, Any]) -> str:
    """The ratio nearest to an end of its range relative to its width, among lengths over D."""
    name, low, high = min(
        ((name, *RANGES[name]) for name in shape if name in PLAIN_FIELDS),
        key=lambda limit: (
            min(shape[limit[0]] - limit[1], limit[2] - shape[limit[0]]) / (limit[2] - limit[1])
        ),
    )
    return f"{ratio_text(name)} = {shape[name]:.3g} of {low:g} to {high:g}"


def _band(value: Any, error: Any) -> tuple[Any, Any]:
    return value * (1.0 - error), value * (1.0 + error)


@summarized("mass [kg]", "band [kg]", "tier")
@dataclass(frozen=True)
class MassLaw:
    """Mass of a throw by the law.

    Attributes
    ----------
    mass : float
        [kg]
    error : float
        Relative half width of the band that holds the true value in 95 of 100 throws.
    tier : str
        "plain" or "real": whether the throw is a plain one.
    """

    mass: float
    error: float
    tier: str

    @property
    def band(self) -> tuple[float, float]:
        """Ends of the band that holds the true value in 95 of 100 throws [kg]."""
        return self.mass * (1.0 - self.error), self.mass * (1.0 + self.error)


def mass_law(throw: CrankThrow, *, density: float = 7850.0) -> MassLaw:
    """Mass of a throw by the law, between the middles of its main journals.

    Parameters
    ----------
    throw : CrankThrow
        Without counterweights.
    density : float
        [kg/m^3]

    Raises
    ------
    InputError
        As `axial_law`; and for counterweights, or a density that is not a positive number.

    Examples
    --------
    >>> throw = CrankThrow(
    ...     crank_radius=0.170, main_journal_diameter=0.220, pin_diameter=0.180,
    ...     main_journal_length=0.120, pin_length=0.139, web_width=0.300, web_thickness=0.068,
    ...     fillet_radius=0.012,
    ... )
    >>> print(f"{mass_law(throw).mass:.1f} kg")
    194.1 kg
    """
    from geometry.mass import check_density  # loads the mesher's modules

    check_density(density)
    webs = {"left_web.": throw.left_web, "right_web.": throw.right_web}
    for name, holder in {"": throw, **webs}.items():
        if holder is not None and holder.counterweight is not None:
            raise InputError(
                f"throw.{name}counterweight: given one; allowed for the law's mass is none, because it gives "
                "the mass of throws without counterweights alone: use analyze_throw for others."
            )
    answers = LawAnswers.of_throw(throw, 1.0, POISSON_RATIO)
    values, widths = answers.values(("volume",))
    volume = float(values[0, 0]) * throw.main_journal_diameter**3
    return MassLaw(density * volume, float(widths[0, 0]), answers.tier)
