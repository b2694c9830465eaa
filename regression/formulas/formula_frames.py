"""What the published formulas give, as a table."""

from collections.abc import Mapping
from typing import Any

from crankbase.tables.frames import table
from regression.formulas.formula_value import FormulaValue


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
