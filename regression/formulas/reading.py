"""A published formula and its readings: the corrected one, the printed one, and others."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass

from regression.formulas.case import ThrowCase
from regression.formulas.formula_value import FormulaValue
from regression.formulas.remarks import Remark, shape_remarks

SURVEY = (
    "A. I. Yamanin, V. A. Zhukov, Vestnik AGTU, Ser. Marine Engineering and Technologies, 2021, "
    "no. 4, pp. 75-83, doi 10.24143/2073-1574-2021-4-75-83"
)


@dataclass(frozen=True)
class Reading:
    """One reading of a formula.

    Attributes
    ----------
    evaluate : callable
        Compliance of a case; called only if there is no fault.
    remarks : callable
        Remarks on that value.
    fault : callable
        Why this reading cannot be evaluated for a case; empty if it can.
    """

    evaluate: Callable[[ThrowCase], float]
    remarks: Callable[[ThrowCase], list[Remark]] = lambda _: []
    fault: Callable[[ThrowCase], str] = lambda _: ""


@dataclass(frozen=True)
class AxialFormula:
    """A published formula for the axial compliance.

    Attributes
    ----------
    name : str
    short : str
        Column heading in tables of all formulas.
    authors : str
        Author and publication.
    readings : mapping of str to Reading
        "corrected", "printed" and others by name.
    printed_fault : str
        Why the print cannot be evaluated for any throw, if it is not among the readings.
    """

    name: str
    short: str
    authors: str
    readings: Mapping[str, Reading]
    printed_fault: str = ""

    @property
    def source(self) -> str:
        """The first publication, and the survey that quotes it."""
        return f"{self.authors}; quoted in {SURVEY}"


def reading_value(
    reading: Reading, case: ThrowCase, source: str, unit: str, variant: str
) -> FormulaValue:
    """Evaluate a reading for a case, with all remarks."""
    remarks = reading.remarks(case) + shape_remarks(case.throw)
    value = reading.evaluate(case)
    if value <= 0.0:
        remarks.append(
            Remark("The value is not positive, which no compliance can be.", invalidates=True)
        )
    return FormulaValue(
        value=value,
        valid=not any(remark.invalidates for remark in remarks),
        remarks=tuple(remark.text for remark in remarks),
        source=source,
        unit=unit,
        variant=variant,
    )
