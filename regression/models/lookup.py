"""What a lookup tells: a value with its unit, its band and what is known of it."""

import itertools
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

from crankbase.summaries import summarized
from regression.models.angle import between_values
from regression.models.error_band import ErrorBand
from regression.models.extrapolation import OutOfRange
from regression.models.response_model import ResponseModel

NO_BAND = "none holds outside the range of the fit"


@summarized("value", "unit", "support", "lower", "upper", "inside", "remarks", keeps_text=True)
@dataclass(frozen=True)
class Lookup:
    """One value from a compliance model, with all that is known about it.

    Parameters
    ----------
    value : float
        The response, in `unit`; never clipped.
    unit : str
        Its SI unit.
    support : str
        How the throw is supported, such as "pinned".
    inside : bool
        Whether everything lies within the range of the fit.
    remarks : tuple of str
        One sentence for each dimension or ratio outside its range, and what else is to be known.
    error : float or None
        Largest relative error of the equation at held-out designs; None if there were none. The band
        counts the error at the runs too.
    equation : str
        The equation in natural units.
    lower, upper : float or None
        Ends of the band in which the response lies: the equation's error and that of the finite
        elements together (see `band`). None outside the range, where no band holds, and where an error
        of 100 % leaves an end open.
    fe_error : float or None
        Largest estimate of the relative error of the finite elements; None if there is none.
    band : str
        How the band was found.
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
        """Say in a line what it is; equation and remarks would fill screens."""
        if self.lower is not None and self.upper is not None:
            band = f", between {self.lower:.4g} and {self.upper:.4g}"
        else:
            band = "" if self.inside else ", outside the range of the fit"
        support = f", {self.support}" if self.support else ""
        return f"Lookup({self.symbol or 'value'} = {self.value:.6g} {self.unit}{support}{band})"


def make_lookup(
    response: ResponseModel, band: ErrorBand, value: float, beyond: Sequence[OutOfRange] = ()
) -> Lookup:
    """Make the lookup of a value: what is known of it."""
    lower, upper = (None, None) if beyond else band.around(value)
    return Lookup(
        value=value,
        unit=response.unit,
        support=response.support,
        inside=not beyond,
        remarks=tuple(one.remark for one in beyond),
        error=response.largest_heldout_error,
        equation=response.equation,
        lower=lower,
        upper=upper,
        fe_error=response.largest_fe_error,
        band=NO_BAND if beyond else band.text,
        symbol=response.symbol,
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
        The value in line, that at 180 deg, and rho. The law rises or falls with each of them, so that
        the ends of its band lie at ends of theirs.
    symbol : str
        Of the response.
    remarks : sequence of str
        What is to be known of the angle law.
    """
    *_, ratio = ends = [(part.lower, part.upper) for part in parts]
    inside = all(part.inside for part in parts)
    # The law has no value where rho, with an error of 100 %, may be 0.
    closed = all(None not in pair for pair in ends) and ratio[0] != 0.0
    corners = [between_values(angle, corner) for corner in itertools.product(*ends) if closed]
    return Lookup(
        value=float(between_values(angle, [part.value for part in parts])),
        unit=parts[0].unit,
        support=f"between neighbors at {angle:g} deg",
        inside=inside,
        remarks=tuple(dict.fromkeys([r for part in parts for r in part.remarks] + [*remarks])),
        error=_largest(part.error for part in parts),
        equation="; ".join(part.equation for part in parts),
        lower=min(corners) if closed else None,
        upper=max(corners) if closed else None,
        fe_error=_largest(part.fe_error for part in parts),
        band="angle law at the ends of the bands of its three numbers: "
        + "; ".join(f"{part.symbol}: {part.band}" for part in parts)
        if inside
        else NO_BAND,
        symbol=f"{symbol}({angle:g} deg)",
    )


def _largest(errors: Iterable[float | None]) -> float | None:
    known = list(errors)
    return None if None in known else max(error for error in known if error is not None)
