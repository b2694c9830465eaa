"""Results of lookups: values with their unit, their bands and remarks."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from crankbase.summaries import summarized
from crankbase.tables.frames import table
from regression.models.angle import between_ends, between_values
from regression.models.extrapolation import ErrorBand
from regression.models.response_model import ResponseModel
from regression.models.response_query import ResponseValues

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
    """Make the lookup of one value, with remarks.

    Parameters
    ----------
    response : ResponseModel
    band : ErrorBand
    answer : ResponseValues
        Of plain numbers.
    remarks : sequence of str
        Remarks on every lookup.
    """
    value, inside = float(answer.values), not answer.outside
    lower, upper = band.around(value) if inside else (None, None)
    return Lookup(
        value=value,
        unit=response.unit,
        support=response.support,
        inside=inside,
        remarks=(*(one.remark for one in answer.outside), *remarks),
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
        remarks=(*(one.remark for one in answer.outside), *remarks),
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

    Parameters
    ----------
    angle : float
        Between neighboring cranks, 0 to 180 [deg].
    parts : sequence of Lookup
        The value in line, that at 180 deg, and rho.
    symbol : str
        Of the response.
    remarks : sequence of str
        Remarks on the angle law.
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
    told = "; ".join(f"{part.symbol}: {part.band}" for part in parts)
    return f"angle law at the ends of the bands of its three numbers: {told}"


def _largest(errors: Iterable[float | None]) -> float | None:
    known = list(errors)
    return None if None in known else max(error for error in known if error is not None)
