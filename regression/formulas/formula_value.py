"""What a published formula gives: a value, and whether it may be trusted for this throw."""

from dataclasses import dataclass

from crankbase.summaries import summarized


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
