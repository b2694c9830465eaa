"""A study's constraints applied to a query: violated ones, and the sentences on them."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from regression.models.extrapolation import OutOfRange
from regression.plans.compiled import Compiled, compile_constraint
from regression.plans.constraints import Constraint, constraint_violations


@dataclass(frozen=True)
class BrokenConstraint:
    """Designs that the study excluded by one of its constraints.

    Attributes
    ----------
    name : str
        The constraint.
    reason : str
        Violation by the first of them.
    number : int
        Their number.
    alone : bool
        As in `OutOfRange`.
    """

    name: str
    reason: str
    number: int
    alone: bool = False

    @property
    def remark(self) -> str:
        """One sentence for a value that is returned nevertheless."""
        return f"{self._given}; the study excluded such designs, so the error is unknown."

    @property
    def error_sentence(self) -> str:
        """One sentence for a value that is refused."""
        return (
            f"{self._given}; allowed are those that keep it, because the study excluded such designs and "
            "strict results are requested."
        )

    def check_distance(self) -> None:
        """Refuse nothing: a constraint is met or violated."""

    @property
    def _given(self) -> str:
        several = f" (and {self.number - 1} more)" if self.number > 1 else ""
        return f"dimensions: given ones by which {self.reason}{several}"


Finding = OutOfRange | BrokenConstraint


class StudyConstraint:
    """A constraint of a study, ready for throws of its size.

    Parameters
    ----------
    read : Constraint
    units : mapping
        SI unit of every name allowed in it.
    """

    def __init__(self, read: Constraint, units: Mapping[str, str]) -> None:
        self.read, self.units = read, units
        self.holds: Compiled = compile_constraint(read)

    def find_broken(self, known: Mapping[str, Any]) -> tuple[BrokenConstraint, Any] | None:
        """Find violations; as `find_out_of_range`, of values at the study's size."""
        used = {name: known[name] for name in self.read.names}
        with np.errstate(all="ignore"):
            held = np.asarray(self.holds(used))
        if np.all(held):
            return None
        place = int(np.argmin(held))
        one = {
            name: np.broadcast_to(value, held.shape).reshape(-1)[place]
            for name, value in used.items()
        }
        (reason,) = constraint_violations(self.read, one, self.units, 1)
        broken = ~held
        found = BrokenConstraint(
            self.read.text, reason or "", int(np.count_nonzero(broken)), alone=held.ndim == 0
        )
        return found, broken if held.ndim else True


def worst(found: Sequence[Finding]) -> list[Finding]:
    """Join findings of pieces of one array: one for each name, with the farthest value."""
    joined: dict[str, Finding] = {}
    for one in found:
        other = joined.get(one.name)
        if other is None:
            joined[one.name] = one
        if other is None or one.alone:  # each piece finds the same number
            continue
        far = other
        if isinstance(one, OutOfRange) and isinstance(other, OutOfRange):
            far = one if one.distance > other.distance else other
        joined[one.name] = replace(far, number=one.number + other.number)
    return list(joined.values())
