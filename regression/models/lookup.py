"""Results of lookups: values with their unit, their bands and remarks."""

import math
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Annotated, Any

import numpy as np
from numpy.typing import ArrayLike

from crankbase.array_checks import Array, Flags, check_sizes, finite_array
from crankbase.errors import InputError
from crankbase.frames import table
from crankbase.results import Part, Quantity, Result, result
from fem.end_reactions import END_LOADS, LARGEST_LOAD, LOAD_UNITS, EndReaction, Reactions
from regression.models.angle import between_ends, between_values
from regression.response_kinds import ThrowLengths

if TYPE_CHECKING:  # a lookup by the law does without
    from regression.models.family import Family
    from regression.models.response_model import ResponseModel
    from regression.models.response_query import ErrorBand, ResponseValues


NO_BAND = "none holds outside the range of the fit"


@result("value", "unit")
class Slope(Result):
    """Derivative of a response by one factor, a float or an array, and its unit, such as "m/N per m"."""

    value: Annotated[float | Array, Quantity(".unit")]
    unit: str


@result("symbol", "value", "unit", "support", "lower", "upper", "inside", "remarks")
class Lookups(Result):
    """Values of one response for many throws, with their bands; like `Lookup` for one.

    Parameters
    ----------
    value : ndarray
        Never clipped.
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

    value: Annotated[Array, Quantity(".unit")]
    lower: Annotated[Array, Quantity(".unit")]
    upper: Annotated[Array, Quantity(".unit")]
    inside: Part[Flags]
    unit: str
    symbol: str
    support: str
    remarks: tuple[str, ...]
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


@result("value", "unit", "support", "lower", "upper", "inside", "remarks", eq=True)
class Lookup(Result):
    """One value from a compliance model, with all information on it.

    Parameters
    ----------
    value : float
        Never clipped.
    lower, upper : float or None
        Ends of the error band of the response: the equation's error and that of the finite
        elements together (see `band`). None outside the range, and if an error
        of 100 % leaves an end open.
    unit : str
        SI unit of these.
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
    fe_error : float or None
        Largest estimate of the relative error of the finite elements; None if there is none.
    band : str
        Origin of the band.
    equation : str
        The equation in natural units.
    """

    value: Annotated[float, Quantity(".unit")]
    lower: Annotated[float | None, Quantity(".unit")]
    upper: Annotated[float | None, Quantity(".unit")]
    unit: str
    symbol: str
    support: str
    inside: bool
    remarks: tuple[str, ...]
    error: Annotated[float | None, Quantity("1", key="largest_held_out_error")]
    fe_error: Annotated[float | None, Quantity("1", key="largest_fe_error_estimate")]
    band: str
    equation: str

    def __repr__(self) -> str:
        """Summarize the lookup in a line; equation and remarks would fill screens."""
        if self.lower is not None and self.upper is not None:
            band = f", between {self.lower:.4g} and {self.upper:.4g}"
        else:
            band = "" if self.inside else ", outside the range of the fit"
        support = f", {self.support}" if self.support else ""
        return f"Lookup({self.symbol or 'value'} = {self.value:.6g} {self.unit}{support}{band})"

    @classmethod
    def of(cls, looked_up: dict[str, Any], responses: "Sequence[ResponseModel]") -> "Lookup":
        """Make the lookup of one throw from the fields of `Lookups`, by the responses used."""
        lower, upper = looked_up["lower"], looked_up["upper"]
        changed = {
            "value": float(looked_up["value"]),
            "lower": float(lower) if math.isfinite(lower) else None,
            "upper": float(upper) if math.isfinite(upper) else None,
            "inside": bool(looked_up["inside"]),
            "band": looked_up["band"] if looked_up["inside"] else NO_BAND,
            "error": _largest([response.largest_heldout_error for response in responses]),
            "fe_error": _largest([response.largest_fe_error for response in responses]),
            "equation": "; ".join([response.equation for response in responses]),
        }
        return cls(**looked_up | changed)


def _largest(errors: Sequence[float | None]) -> float | None:
    known = [error for error in errors if error is not None]
    return max(known) if len(known) == len(errors) else None


def look_up(
    response: "ResponseModel", band: "ErrorBand", answer: "ResponseValues"
) -> dict[str, Any]:
    """Return the fields of `Lookups`, floats or arrays."""
    lower, upper = band.around(answer.values, answer.inside, answer.errors)
    return {
        "value": answer.values,
        "lower": lower,
        "upper": upper,
        "inside": answer.inside,
        "remarks": tuple([finding.remark for finding in answer.outside]),
        "unit": response.unit,
        "support": response.support,
        "symbol": response.symbol,
        "band": band.text,
    }


def look_up_between_neighbors(
    angle: Any, parts: Sequence[dict[str, Any]], symbol: str, shown: str, remarks: Sequence[str]
) -> dict[str, Any]:
    """Look throws between neighbors up: their bands are those of the three numbers together.

    Angles between neighboring cranks are 0 to 180 [deg]; the parts are the values in line, at 180
    deg, and rho; `shown` names the angle, "" for several.
    """
    value = between_values(angle, [part["value"] for part in parts])
    inside = np.logical_and.reduce([part["inside"] for part in parts])
    ends = [(part["lower"], part["upper"]) for part in parts]
    # The law has no value where rho is none or, with an error of 100 %, may be 0.
    known = inside & np.isfinite(ends).all(axis=(0, 1)) & (ends[-1][0] > 0.0)
    lower, upper = between_ends(
        angle, [(np.where(known, low, 1.0), np.where(known, high, 1.0)) for low, high in ends]
    )
    bands = "; ".join(f"{part['symbol']}: {part['band']}" for part in parts)
    return {
        "value": value,
        "lower": np.where(known, lower, -np.inf),
        "upper": np.where(known, upper, np.inf),
        "inside": np.broadcast_to(inside, np.shape(value)),
        "remarks": tuple(dict.fromkeys([*(r for p in parts for r in p["remarks"]), *remarks])),
        "unit": parts[0]["unit"],
        "support": f"between neighbors at {shown}" if shown else "between neighbors",
        "symbol": f"{symbol}({shown or 'gamma'})",
        "band": f"angle law at the ends of the bands of its three numbers: {bands}",
    }


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
    inside: Annotated[Flags, Quantity()]
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


def throw_lengths(family: "Family", query: Mapping[str, ArrayLike | str]) -> ThrowLengths:
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
