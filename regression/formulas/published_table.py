"""The survey's table of axial compliances: the printed values, and their lost powers of ten.

Yamanin and Zhukov give the axial compliance of one throw of ten engines by nine formulas, with the
column heading 1e9. Some values are off by powers of ten compared with the rest of their row and column;
they look like mantissas of a spreadsheet whose exponents were lost. The file keeps the printed
digits and, as a hypothesis in a separate column, the power of ten for each.

The paper gives no dimensions of the throws, and no single set of dimensions makes all columns agree
(groups A and B of the file). The table shows the spread of the formulas; it cannot verify any of them.
"""

import csv
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from crankbase.errors import InputError

FINITE_ELEMENTS = "finite elements"
COLUMNS = (
    "engine",
    "strokes",
    "bore_mm",
    "stroke_mm",
    "formula",
    "printed_1e-9_m_per_N",
    "exponent_factor",
    "group",
    "doubt",
)
# The value by finite elements that the paper gives for one engine is doubted in words of its own.
FINITE_ELEMENTS_DOUBT = (
    "The survey's value by finite elements for ChN 26/26, 3.3220e-9 m/N, is probably 3.3220e-10 m/N: "
    "as printed it is at least twice what any formula gives in its row, and four to eight times what "
    "finite elements give for throws of that size between opposite neighbors. It is no validation "
    "target."
)


@dataclass(frozen=True)
class PublishedValue:
    """One value of the survey's table.

    Attributes
    ----------
    engine : str
        Designation: cylinder bore / stroke [cm]; from it bore and stroke [m].
    strokes : int
        4 or 2.
    formula : str
        As in `AXIAL_FORMULA_NAMES`, or "finite elements".
    digits : str
        The digits of the print.
    exponent_factor : float or None
        Power of ten to apply to the print, a hypothesis; 1 where none seems necessary, None if unknown.
    group : str
        "A" or "B": formulas whose values agree with one web thickness; empty for neither.
    doubt : str
        Doubts; empty if none.
    """

    engine: str
    strokes: int
    bore: float
    stroke: float
    formula: str
    digits: str
    exponent_factor: float | None
    group: str
    doubt: str

    @property
    def printed(self) -> float:
        """The value as printed [m/N]."""
        return float(self.digits) * 1e-9

    @property
    def repaired(self) -> float | None:
        """The printed value times its hypothetical power of ten [m/N]; None where there is none."""
        return None if self.exponent_factor is None else self.printed * self.exponent_factor

    @property
    def mark(self) -> str:
        """Return "*" if the power of ten was repaired, "?" if it is doubted only, or ""."""
        if self.exponent_factor not in (None, 1.0):
            return "*"
        return "?" if self.doubt else ""


def read_published_table(path: Path) -> tuple[PublishedValue, ...]:
    """Read the survey's table, ``axial_compliance_published.csv``, in the order of the print.

    Raises
    ------
    InputError
        If the file does not exist or is not in this table's format.
    """
    if not path.is_file():
        raise InputError(f"{path}: given as the published table, but there is no such file.")
    lines = [
        line
        for line in path.read_text(encoding="utf-8").splitlines()
        if line.strip() and not line.startswith("#")
    ]
    rows = csv.DictReader(lines)
    if tuple(rows.fieldnames or ()) != COLUMNS:
        raise InputError(
            f"{path}: given columns {', '.join(rows.fieldnames or ['none'])}; allowed are "
            f"{', '.join(COLUMNS)}, those of the published table."
        )
    return tuple(_value(path, number, row) for number, row in enumerate(rows, start=1))


def _value(path: Path, number: int, row: Mapping[str, str]) -> PublishedValue:
    try:
        factor = row["exponent_factor"]
        value = PublishedValue(
            engine=row["engine"],
            strokes=int(row["strokes"]),
            bore=float(row["bore_mm"]) / 1e3,
            stroke=float(row["stroke_mm"]) / 1e3,
            formula=row["formula"],
            digits=row["printed_1e-9_m_per_N"],
            exponent_factor=float(factor) if factor else None,
            group=row["group"],
            doubt=row["doubt"],
        )
        positive = value.printed > 0.0
    except (TypeError, ValueError) as error:
        raise InputError(f"{path}: row {number} of the table cannot be read: {error}.") from None
    if not positive:
        raise InputError(
            f"{path}: row {number} gives {value.digits}; allowed is a positive number, because it "
            "is a compliance."
        )
    return value
