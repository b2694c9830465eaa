"""Range of the required accuracy of a finite element result."""

from dataclasses import dataclass

from crankbase.choices import number_within


@dataclass(frozen=True)
class AccuracyRange:
    """Allowed relative accuracies, and the quantity they refer to."""

    least: float
    most: float
    error_of: str

    def __str__(self) -> str:
        return f"{self.least:g} to {self.most:g}"

    def checked(self, field: str, accuracy: object) -> float:
        """Return a required accuracy, checked.

        Raises
        ------
        InputError
            If it is not a number of the range.
        """
        reason = f"it is the relative error of {self.error_of}"
        return number_within(field, accuracy, self.least, self.most, "", reason)


COMPLIANCE_ACCURACY = AccuracyRange(0.001, 0.1, "e_n")
STRESS_ACCURACY = AccuracyRange(0.02, 0.2, "stresses")
