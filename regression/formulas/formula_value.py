"""The result of a published formula: a value, and whether the formula applies to the throw."""

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
        False if the throw is outside the formula's range of validity. The value
        is then for comparison only.
    remarks : tuple of str
        Remarks on this value, one sentence each.
    source : str
        Where the formula was published.
    unit : str
        SI unit of `value`.
    variant : str
        The reading of the formula: "corrected", "printed", ...
    """

    value: float
    valid: bool
    remarks: tuple[str, ...]
    source: str
    unit: str
    variant: str


def formulas_to_pandas(found: Mapping[str, FormulaValue]) -> Any:
    """Return a table of the results of the published formulas.

    Parameters
    ----------
    found : mapping of str to FormulaValue
        From `axial_formulas` or `torsional_formulas`.

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
