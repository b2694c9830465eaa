"""How accurate a finite element result may be wished to be."""

from dataclasses import dataclass

from crankbase.checks.scalars import is_number
from crankbase.errors import InputError, quoted


@dataclass(frozen=True)
class AccuracyRange:
    """Relative accuracies that may be wished, and what they are the error of."""

    least: float
    most: float
    error_of: str

    def __str__(self) -> str:
        return f"{self.least:g} to {self.most:g}"

    def checked(self, field: str, given: object) -> float:
        """Return a wished accuracy.

        Raises
        ------
        InputError
            If it is no number of the range.
        """
        if not is_number(given) or not self.least <= given <= self.most:
            raise InputError(
                f"{field}: given {quoted(given)}; allowed is a number from {self}, the relative error of "
                f"{self.error_of}."
            )
        return float(given)


COMPLIANCE_ACCURACY = AccuracyRange(0.001, 0.1, "e_n")
STRESS_ACCURACY = AccuracyRange(0.02, 0.2, "stresses")
