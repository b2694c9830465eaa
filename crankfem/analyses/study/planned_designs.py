"""The designs of a study before any is computed: which, how well spread, and which are excluded."""

import re
from collections import Counter, defaultdict
from collections.abc import Iterator, Mapping
from typing import Annotated

import numpy as np

from crankbase.quantity import DISPLAY_UNITS
from crankbase.results import Internal, Quantity, Result, result
from crankbase.sentences import finished, kept
from crankbase.table import Column, Main, OutputUnit, Table
from regression.plans.designs import DesignQuality, design_quality
from regression.plans.plan import ExcludedDesign, PlannedStudy
from regression.records import HELD_OUT, RUN

# More lines than this nobody reads.
MOST_ROWS = 200
MOST_REASONS = 12
# Reasons that differ in numbers alone are told once.
NUMBER = re.compile(r"\d[\d.]*(?:e[+-]?\d+)?")


@result("name", "unit", "labels")
class FactorName(Result):
    """A factor with its SI unit; a choice has labels."""

    name: str
    unit: str
    labels: tuple[str, ...]


@result("role", "values")
class ListedDesign(Result):
    """A design by its factors, choices by their labels: with its key, or why it is excluded."""

    role: str
    values: Annotated[Mapping[str, float | str], Quantity(".units")]
    units: Internal[Mapping[str, str]]
    key: Annotated[str | None, Quantity(left_out=True)] = None
    reason: Annotated[str | None, Quantity(left_out=True)] = None


@result("study", "statement", "designs", "excluded")
class PlannedDesigns(Result):
    """The designs of a study, the runs before the held-out ones."""

    planned: Internal[PlannedStudy]
    study: str
    statement: str
    remarks: tuple[str, ...]
    quality: DesignQuality
    factors: tuple[FactorName, ...]
    designs: tuple[ListedDesign, ...]
    excluded: tuple[ListedDesign, ...]

    @classmethod
    def of(cls, planned: PlannedStudy) -> "PlannedDesigns":
        """List the designs of a plan."""
        plan = planned.plan
        factors = plan.factors
        runs = [design.values for design in planned.designs if design.role == RUN]
        units = {factor.name: factor.unit or "1" for factor in factors if not factor.labels}

        def named(values: tuple[float, ...]) -> dict[str, float | str]:
            pairs = zip(factors, values, strict=True)
            return {factor.name: factor.setting(value) for factor, value in pairs}

        return cls(
            planned=planned,
            study=plan.key,
            statement=planned.statement,
            remarks=planned.remarks,
            quality=design_quality(factors, np.array(runs)),
            factors=tuple(FactorName(part.name, part.unit, part.labels) for part in factors),
            designs=tuple(
                ListedDesign(part.role, named(part.values), units, key=part.key)
                for part in planned.designs
            ),
            excluded=tuple(
                ListedDesign(part.role, named(part.values), units, reason=part.reason)
                for part in planned.excluded
            ),
        )

    def parts(self) -> Iterator[Table | str]:
        """List the designs, how well they are spread, and which are excluded and why."""
        plan, quality = self.planned.plan, self.quality
        held_out = sum(design.role == HELD_OUT for design in self.designs)
        distance = (
            "" if quality.distance is None else f"nearest runs {quality.distance:.3g} apart, "
        )
        columns = [Column("design"), Column("role", words=True)]
        for factor in plan.factors:
            unit, size = DISPLAY_UNITS.get(factor.unit, (factor.unit, 1.0))
            shown = OutputUnit(unit, size)
            columns.append(Column(factor.name, shown, 6, words=bool(factor.labels)))
        yield Table(
            "Designs",
            columns,
            [
                [number, design.role, *design.values.values()]
                for number, design in enumerate(self.designs[:MOST_ROWS], start=1)
            ],
            main=True,
        )
        if len(self.designs) > MOST_ROWS:
            yield f"... and {len(self.designs) - MOST_ROWS} more; --json has them all."
        for path, text in plan.relations.items():
            yield f"In every design {path} = {text}."
        for remark in self.remarks:
            yield Main(f"Note: {remark}")
        if self.excluded:
            roles = Counter(design.role for design in self.excluded)
            counts = ", ".join(
                f"{count} {'runs' if role == RUN and count > 1 else role}"
                for role, count in roles.items()
            )
            yield Main(f"Excluded before any finite-element run: {counts}.")
            yield from self._reasons()
        yield Main(
            f"Runs in the unit cube: {distance}discrepancy {quality.discrepancy:.2g} (random points: "
            f"{quality.random_discrepancy:.2g})."
        )
        if quality.correlated:
            yield Main(
                f"Largest correlation of two factors: {quality.correlation:.2g}, of "
                f"{' and '.join(quality.correlated)}."
            )
        elif quality.correlation is not None:
            yield Main("No two factors are correlated.")
        yield Main(
            f"{self.statement[0].upper()}{self.statement[1:]}; {held_out} held-out designs to judge the "
            f"fits (Latin hypercube, seed {plan.seed})."
        )

    def _reasons(self) -> Iterator[str]:
        """State why designs are excluded; of those for the same reason only the first."""
        alike: dict[str, list[ExcludedDesign]] = defaultdict(list)
        for design in self.planned.excluded:
            alike[NUMBER.sub("#", design.reason)].append(design)
        groups = sorted(alike.values(), key=len, reverse=True)
        for designs in groups[:MOST_REASONS]:
            first = designs[0]
            values = ", ".join(
                f"{factor.name} {kept(factor.format_value(value))}"
                for factor, value in zip(self.planned.plan.factors, first.values, strict=True)
            )
            more = f" ({len(designs) - 1} more alike)" if len(designs) > 1 else ""
            yield finished(f"  {first.role}, {values}: {first.reason.rstrip('.')}{more}.")
        if len(groups) > MOST_REASONS:
            yield f"  ... and {len(groups) - MOST_REASONS} other reasons; --json has them all."
