"""Results of lookups: values with their unit, their bands and remarks."""

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from crankbase.array_checks import check_sizes, finite_array
from crankbase.errors import InputError
from crankbase.frames import table
from crankbase.results import Quantity, result
from crankbase.summaries import summarized
from fem.supports import END_LOADS, LARGEST_LOAD, LOAD_UNITS, EndReaction, Reactions
from geometry.throw import CrankThrow
from regression.models.angle import between_ends, between_values
from regression.models.extrapolation import ErrorBand
from regression.models.family import Family, angle_law_remarks
from regression.models.response_model import ResponseModel
from regression.models.response_query import ResponseValues
from regression.response_kinds import NEEDED, RIGHT_MOMENTS, ThrowLengths, end_reactions

if TYPE_CHECKING:
    from fem.supports import Support
    from regression.models.model_file import ModelContent


NO_BAND = "none holds outside the range of the fit"


@summarized("value", "unit", "support", "lower", "upper", "inside", "remarks", keeps_text=True)
@dataclass(frozen=True)
class Lookup:
    """One value from a compliance model, with all information on it.

    Parameters
    ----------
    value : float
        The response, in `unit`; never clipped.
    unit : str
        Its SI unit.
    support : str
        Support of the throw, such as "pinned".
    inside : bool
        Whether everything is within the range of the fit and the study's constraints.
    remarks : tuple of str
        One sentence for each dimension or ratio outside its range and each constraint of the study that
        is violated, and further remarks.
    error : float or None
        Largest relative error of the equation at held-out designs; None if there were none. The error
        used for the band is in `band`.
    equation : str
        The equation in natural units.
    lower, upper : float or None
        Ends of the error band of the response: the equation's error and that of the finite
        elements together (see `band`). None outside the range, and if an error
        of 100 % leaves an end open.
    fe_error : float or None
        Largest estimate of the relative error of the finite elements; None if there is none.
    band : str
        Origin of the band.
    symbol : str
        Symbol of the response.
    """

    value: float
    unit: str
    support: str
    inside: bool
    remarks: tuple[str, ...]
    error: float | None
    equation: str
    lower: float | None = None
    upper: float | None = None
    fe_error: float | None = None
    band: str = ""
    symbol: str = ""

    def __repr__(self) -> str:
        """Summarize the lookup in a line; equation and remarks would fill screens."""
        if self.lower is not None and self.upper is not None:
            band = f", between {self.lower:.4g} and {self.upper:.4g}"
        else:
            band = "" if self.inside else ", outside the range of the fit"
        support = f", {self.support}" if self.support else ""
        return f"Lookup({self.symbol or 'value'} = {self.value:.6g} {self.unit}{support}{band})"


@summarized("symbol", "value", "unit", "support", "lower", "upper", "inside", "remarks")
@dataclass(frozen=True, eq=False)
class Lookups:
    """Values of one response for many throws, with their bands; like `Lookup` for one.

    Parameters
    ----------
    value : ndarray
        The response, in `unit`; never clipped.
    lower, upper : ndarray
        Ends of the band of each value. Infinite outside the study, and if an error
        of 100 % leaves an end open.
    inside : ndarray of bool
        Where everything is within the study.
    remarks : tuple of str
        One sentence for each range and constraint violated, with the number of throws and the
        farthest of them; and further remarks.
    unit, support, symbol, band : str
        As in `Lookup`; origin of the band.
    """

    value: NDArray[np.float64]
    lower: NDArray[np.float64]
    upper: NDArray[np.float64]
    inside: NDArray[np.bool_]
    remarks: tuple[str, ...]
    unit: str
    support: str
    symbol: str
    band: str

    def to_pandas(self) -> Any:
        """Return a table of the throws in C order: value, lower, upper, inside.

        Returns
        -------
        pandas.DataFrame
            ``frame.attrs["units"]`` has the units of the columns.

        Raises
        ------
        MissingLibraryError
            If pandas is not installed.
        """
        unit = self.unit or "1"
        numbers = {
            name: (getattr(self, name).ravel(), unit) for name in ("value", "lower", "upper")
        }
        return table({**numbers, "inside": (self.inside.ravel(), "")})


def make_lookup(
    response: ResponseModel, band: ErrorBand, answer: ResponseValues, remarks: Sequence[str] = ()
) -> Lookup:
    """Make the lookup of one value, with remarks that are on every lookup."""
    value, inside = float(answer.values), not answer.outside
    lower, upper = band.around(value) if inside else (None, None)
    return Lookup(
        value=value,
        unit=response.unit,
        support=response.support,
        inside=inside,
        remarks=(*(finding.remark for finding in answer.outside), *remarks),
        error=response.largest_heldout_error,
        equation=response.equation,
        lower=lower,
        upper=upper,
        fe_error=response.largest_fe_error,
        band=band.text if inside else NO_BAND,
        symbol=response.symbol,
    )


def make_lookups(
    response: ResponseModel, band: ErrorBand, answer: ResponseValues, remarks: Sequence[str] = ()
) -> Lookups:
    """Make the lookups of an array of values, as `make_lookup` for one."""
    values, inside = np.asarray(answer.values), np.asarray(answer.inside)
    lower, upper = band.around_all(values)
    if not np.all(inside):
        lower, upper = np.where(inside, lower, -np.inf), np.where(inside, upper, np.inf)
    return Lookups(
        value=values,
        lower=lower,
        upper=upper,
        inside=inside,
        remarks=(*(finding.remark for finding in answer.outside), *remarks),
        unit=response.unit,
        support=response.support,
        symbol=response.symbol,
        band=band.text,
    )


def make_lookups_between_neighbors(
    angle: Any, parts: Sequence[Lookups], symbol: str, remarks: Sequence[str] = ()
) -> Lookups:
    """Make the lookups of throws between neighbors, as `make_lookup_between_neighbors` for one."""
    value = np.asarray(between_values(angle, [part.value for part in parts]))
    inside = np.logical_and.reduce([part.inside for part in parts])
    ends = [(part.lower, part.upper) for part in parts]
    # The law has no value where rho is none or, with an error of 100 %, may be 0.
    known = inside & np.isfinite(ends).all(axis=(0, 1)) & (parts[-1].lower > 0.0)
    lower, upper = between_ends(
        angle, [(np.where(known, low, 1.0), np.where(known, high, 1.0)) for low, high in ends]
    )
    lower, upper = np.where(known, lower, -np.inf), np.where(known, upper, np.inf)
    return Lookups(
        value=value,
        lower=lower,
        upper=upper,
        inside=np.broadcast_to(inside, value.shape),
        remarks=tuple(dict.fromkeys([r for part in parts for r in part.remarks] + [*remarks])),
        unit=parts[0].unit,
        support="between neighbors",
        symbol=f"{symbol}(gamma)",
        band=_law_band(parts),
    )


def make_lookup_between_neighbors(
    angle: float, parts: Sequence[Lookup], symbol: str, remarks: Sequence[str] = ()
) -> Lookup:
    """Make the lookup of a throw between neighbors: its band is that of the three numbers together.

    The angle between neighboring cranks is 0 to 180 [deg]; the parts are the values in line, at 180
    deg, and rho.
    """
    *_, ratio = ends = [(part.lower, part.upper) for part in parts]
    inside = all(part.inside for part in parts)
    # The law has no value where rho, with an error of 100 %, may be 0.
    closed = all(None not in pair for pair in ends) and ratio[0] != 0.0
    lower, upper = between_ends(angle, ends) if closed else (None, None)
    return Lookup(
        value=float(between_values(angle, [part.value for part in parts])),
        unit=parts[0].unit,
        support=f"between neighbors at {angle:g} deg",
        inside=inside,
        remarks=tuple(dict.fromkeys([r for part in parts for r in part.remarks] + [*remarks])),
        error=_largest(part.error for part in parts),
        equation="; ".join(part.equation for part in parts),
        lower=lower,
        upper=upper,
        fe_error=_largest(part.fe_error for part in parts),
        band=_law_band(parts) if inside else NO_BAND,
        symbol=f"{symbol}({angle:g} deg)",
    )


def _law_band(parts: Sequence[Lookup | Lookups]) -> str:
    bands = "; ".join(f"{part.symbol}: {part.band}" for part in parts)
    return f"angle law at the ends of the bands of its three numbers: {bands}"


def _largest(errors: Iterable[float | None]) -> float | None:
    known = list(errors)
    return None if None in known else max(error for error in known if error is not None)


Array = NDArray[np.float64]

# Beginnings of names of what a throw has that its first pin's reactions do not tell of.
_OTHER_PARTS = ("further_pins.", "oil_holes.")
_WEBS = ("left_web.thickness", "right_web.thickness")


@result(
    "support",
    "left force: left.force",
    "left moment: left.moment",
    "right force: right.force",
    "right moment: right.moment",
    "remarks",
)
class ReactionLookup(Reactions):
    """Reactions from a compliance model, with their errors.

    Attributes
    ----------
    left, right : EndReaction
        Force [N] and moment [N m], each (3,), or (..., 3) of many throws, in the throw frame.
    band : Reactions
        Error of each component, from the bands of the equations together: 0 where
        equilibrium decides alone. Infinite without a valid band, as outside the range.
    inside : ndarray of bool
        Where everything is within the range of the fits.
    remarks : tuple of str
        As in `Lookup`.
    """

    band: Reactions
    support: str
    inside: Annotated[NDArray[np.bool_], Quantity()]
    remarks: tuple[str, ...]

    def to_pandas(self) -> Any:
        """Return a table of the ends; of many throws one of the throws in C order, "left Fx" to "right Mz".

        Returns
        -------
        pandas.DataFrame
            Units are in ``frame.attrs["units"]``.

        Raises
        ------
        MissingLibraryError
            If pandas is not installed.
        """
        if self.left.force.ndim == 1:
            return super().to_pandas()
        ends = (self.left.force, self.left.moment, self.right.force, self.right.moment)
        columns = np.concatenate(ends, axis=-1).reshape(-1, 12).T
        return table(dict(zip(END_LOADS, zip(columns, LOAD_UNITS * 2, strict=True), strict=True)))


def look_reactions_up(
    model: "ModelContent",
    lookups: "Callable[..., Lookups]",
    pin_force: ArrayLike,
    support: "Support",
    strict: bool,
    dimensions: Mapping[str, ArrayLike | str],
) -> ReactionLookup:
    """Find reactions for `ComplianceModel.reactions`, with a function that looks its responses up."""
    force = checked_force(pin_force)
    kind, gamma = checked_support(support)
    _check_throws(model, kind)
    missing = [name for name in NEEDED[kind] if name not in model.responses]
    if missing:
        raise InputError(
            f"support: given {support_words(kind, gamma)}, but the model has no {missing[0]}; reactions "
            f"there need {', '.join(NEEDED[kind])}: run and fit its study again, because this release has "
            "studies keep them."
        )
    looked_up = {name: lookups(name, strict=strict, **dimensions) for name in NEEDED[kind]}
    inside = np.logical_and.reduce([answer.inside for answer in looked_up.values()])
    _check_shapes(force, inside)
    lengths = throw_lengths(model.family, dimensions)
    values: dict[str, Any] = {name: answer.value for name, answer in looked_up.items()}

    # One number for both ends, if they are alike.
    twins = {} if angle_law_remarks(model.family, model.throw) else RIGHT_MOMENTS
    values |= {right: values[left] for left, right in twins.items() if left in values}

    def loads(name: str = "", ends: Any = None) -> Array:
        changed = {} if not name else {name: ends, twins.get(name, name): ends}
        return end_reactions(values | changed, lengths, force, gamma)

    middle = loads()
    band = np.zeros_like(middle)
    for name, answer in looked_up.items():
        if name in twins.values():
            continue
        open_ended = ~(np.isfinite(answer.lower) & np.isfinite(answer.upper))
        ends = (np.where(open_ended, answer.value, end) for end in (answer.lower, answer.upper))
        band += np.maximum(*(np.abs(loads(name, end) - middle) for end in ends))
        band[np.broadcast_to(open_ended, band.shape[:-1])] = np.inf
    return ReactionLookup(
        *both_ends(middle),
        band=Reactions(*both_ends(band)),
        support=support_words(kind, gamma),
        inside=np.broadcast_to(inside, middle.shape[:-1]),
        remarks=tuple(
            dict.fromkeys(remark for answer in looked_up.values() for remark in answer.remarks)
        ),
    )


def throw_lengths(family: Family, query: Mapping[str, ArrayLike | str]) -> ThrowLengths:
    """Lengths of throws of a family, from given and fixed ones; `InputError` if one is unknown."""
    checked = family.checked(query)
    known = family.completed(checked, family.size(checked))
    needed = ("crank_radius", "main_journal_length", "pin_length", "web_thickness")
    missing = [name for name in needed if name not in known]
    if missing:
        raise InputError(
            f"{missing[0]}: missing; reactions need it, because they are in equilibrium with the force on "
            "the pin."
        )
    radius, journal, pin, web = (known[name] for name in needed)
    left, right = (known.get(name, web) for name in _WEBS)
    to_pin = journal / 2.0 + left + pin / 2.0
    return ThrowLengths(to_pin + pin / 2.0 + right + journal / 2.0, to_pin, radius)


def both_ends(loads: Array) -> tuple[EndReaction, EndReaction]:
    """Return the reactions on the left and on the right end, from loads (..., 12)."""
    left, right = (
        EndReaction(loads[..., start : start + 3], loads[..., start + 3 : start + 6])
        for start in (0, 6)
    )
    return left, right


def checked_force(pin_force: ArrayLike) -> Array:
    """Forces (..., 3) on a pin, across the shaft [N]; `InputError` for others."""
    force = finite_array("pin_force", pin_force)
    if force.shape[-1:] != (3,):
        raise InputError(
            f"pin_force: given an array of shape {force.shape}; allowed are x, y and z in the throw frame "
            "[N], for many throws a row of them for each."
        )
    check_sizes("pin_force", force, LARGEST_LOAD)
    axial = force[..., 2].ravel()
    if np.any(axial):
        raise InputError(
            f"pin_force: given {axial[np.argmax(np.abs(axial))]:g} N along the shaft; allowed are forces "
            "across it, x and y, because the model covers no others: use analyze_throw for these and for "
            "moments on a pin."
        )
    return force


def checked_support(support: object) -> tuple[str, float | None]:
    """Kind of a support, as in `NEEDED`, and the angle between neighbors [deg]; `InputError` for others."""
    if isinstance(support, str) and support in ("pinned", "guided"):
        return support, None
    left, right = (getattr(support, f"{side}_deg", None) for side in ("left", "right"))
    if not isinstance(left, int | float) or not isinstance(right, int | float):
        raise InputError(
            f'support: given {support!r}; allowed are "pinned", "guided" or Neighbors(left_deg, right_deg), '
            "because reactions depend on it."
        )
    if (left - right) % 360.0:
        raise InputError(
            f"support: given Neighbors({left:g}, {right:g}); allowed are equal angles, because the model "
            "covers only throws in a helix: use analyze_throw for others."
        )
    return "neighbors", float(left)


def support_words(kind: str, gamma: float | None) -> str:
    """Describe the support of a throw."""
    return kind if gamma is None else f"between neighbors at {gamma:g} deg"


def _check_throws(model: "ModelContent", kind: str) -> None:
    """Refuse throws whose reactions do not follow from the model's numbers."""
    family, throw = model.family, model.throw
    names = [*family.factors, *family.relations, *family.fixed, *family.labels]
    part = next((name for name in names if name.startswith(_OTHER_PARTS)), None)
    if part is not None or (throw is not None and CrankThrow(**throw).symmetry == "full"):
        raise InputError(
            f"reactions: given a model of throws with {part or 'parts beside the crank plane'}; allowed are "
            "throws of one pin that are symmetric about the crank plane, because for others a force in "
            "that plane does not leave the ends in it: use analyze_throw."
        )
    if kind == "neighbors" and angle_law_remarks(family, throw):
        raise InputError(
            "support: given Neighbors to a model of throws that are not alike from both ends; allowed are "
            '"pinned" and "guided", because only equal webs have reactions in closed form between '
            "neighbors: use analyze_throw."
        )


def _check_shapes(force: Array, inside: NDArray[np.bool_]) -> None:
    try:
        np.broadcast_shapes(force.shape[:-1], inside.shape)
    except ValueError:
        raise InputError(
            f"pin_force: given an array of shape {force.shape} for dimensions of shape {inside.shape}; "
            "allowed are three numbers, or rows of them that can be broadcast with the dimensions."
        ) from None
