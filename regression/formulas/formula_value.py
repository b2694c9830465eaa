"""What a published formula gives: a value, and whether it may be trusted for this throw."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from crankbase.summaries import summarized
from crankbase.tables.frames import table


@summarized("value", "unit", "valid", "remarks", "source", "variant")
@dataclass(frozen=True)
class FormulaValue:
    """The result of one published formula for one crank throw.

    Parameters
    ----------
    value : float
        The formula's value, in `unit`; always finite.
    valid : bool
        False if the throw lies outside the range in which the formula has a meaning. The value
        is then what the formula gives all the same, for comparison only.
    remarks : tuple of str
        One sentence for each thing to know about this value; empty if there is none.
    source : str
        Where the formula was published.
    unit : str
        SI unit of `value`.
    variant : str
        Which reading of the formula this is: "corrected", "printed", ...
    """

    value: float
    valid: bool
    remarks: tuple[str, ...]
    source: str
    unit: str
    variant: str


def formulas_to_pandas(found: Mapping[str, FormulaValue]) -> Any:
    """Return a table of what the published formulas give.

    Parameters
    ----------
    found : mapping of str to FormulaValue
        As `axial_formulas` or `torsional_formulas` returns it.

    Returns
    -------
    pandas.DataFrame
        ``formula``, ``value``, ``valid``, ``variant``, ``remarks``, ``source``; the unit of the
        values is in ``frame.attrs["units"]``.

    Raises
    ------
    MissingLibraryError
        If pandas is not installed.
    """
    values = list(found.values())
    units = " or ".join(dict.fromkeys(one.unit for one in values))
    return table(
        {
            "formula": (list(found), ""),
            "value": ([one.value for one in values], units),
            "valid": ([one.valid for one in values], ""),
            "variant": ([one.variant for one in values], ""),
            "remarks": (["; ".join(one.remarks) for one in values], ""),
            "source": ([one.source for one in values], ""),
        }
    )
