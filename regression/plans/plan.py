"""The plan of a study: a base throw, factors, a design, and the resulting list of designs."""

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, field
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from crankbase.errors import InputError
from fem.material import STEEL, Material
from geometry.throw import CrankThrow
from regression.plans.designs import (
    HELD_OUT_STREAM,
    RUN_STREAM,
    SPACE_FILLING,
    DesignChoice,
    check_ranges,
    fixed_design,
    space_filling_points,
    space_filling_statement,
    values_at,
)
from regression.plans.designs_space import draw_feasible_points
from regression.plans.factors import Factor
from regression.plans.variants import Variant, Variants
from regression.records import HELD_OUT, RUN, content_key

# Raise when a change of the model changes results: stored results of older versions are not used.
MODEL_VERSION = 6


@dataclass(frozen=True)
class StudyPlan:
    """A base throw, its factors and design, and held-out designs.

    Parameters
    ----------
    throw : CrankThrow
        Supplies all dimensions that are neither factors nor follow from relations.
    factors : tuple of Factor
        What varies, in order.
    design : DesignChoice
        Which combinations are run and fitted.
    relations : mapping
        Field of the throw to an expression of factors, other fields and quantities with units.
    constraints : tuple of str
        Comparisons that every design must meet; others are excluded.
    held_out : int
        Number of further designs, 1 to 1000, spread over the ranges by a Latin hypercube, that are run
        and not used in the fit: they assess the fit. They depend on the ranges, the relations, the
        constraints and the seed, not on the design, so different designs have the same ones.
    seed : int
        Seed of all random draws.
    material : Material
    accuracy : float
        Relative accuracy of each design's axial compliance, 0.001 to 0.1.
    stresses : bool
        Whether the fillet stresses are computed as well.

    Raises
    ------
    InputError
        If a factor, relation or constraint names something unknown or does not fit the others.
    """

    throw: CrankThrow
    factors: tuple[Factor, ...]
    design: DesignChoice = field(default_factory=DesignChoice)
    relations: Mapping[str, str] = field(default_factory=dict)
    constraints: tuple[str, ...] = ()
    held_out: int = 10
    seed: int = 1
    material: Material = STEEL
    accuracy: float = 0.01
    stresses: bool = False

    def __post_init__(self) -> None:
        if all(factor.categorical for factor in self.factors):
            raise InputError(
                f"study.factors: given {', '.join(self.names) or 'none'}; allowed is at least one factor "
                "that is a number, because an equation needs something to vary in."
            )
        if self.design.kind in SPACE_FILLING:
            check_ranges(self.factors, self.design.kind)
        self.variants()  # refuses what does not fit together

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the factors."""
        return tuple(factor.name for factor in self.factors)

    def variants(self) -> Variants:
        """Return the function that makes throws of factor values."""
        return Variants.of(self.throw, self.factors, self.relations, self.constraints)

    @property
    def settings(self) -> dict[str, Any]:
        """Common inputs of all designs, as JSON content."""
        return {
            "material": self.material.model_dump(),
            "accuracy": self.accuracy,
            "stresses": self.stresses,
        }

    def as_record(self) -> dict[str, Any]:
        """Everything that identifies the study, as JSON content in SI units."""
        return {
            "throw": self.throw.model_dump(mode="json"),
            # A list, because the order of the factors decides which designs are held out.
            "factors": [asdict(factor) for factor in self.factors],
            "design": asdict(self.design),
            "relations": dict(sorted(self.relations.items())),
            "constraints": list(self.constraints),
            "held_out": self.held_out,
            "seed": self.seed,
            **self.settings,
            "model_version": MODEL_VERSION,
        }

    @classmethod
    def from_record(cls, record: Mapping[str, Any]) -> "StudyPlan":
        """Rebuild a plan from `as_record`, as stored."""
        design, rows = record["design"], record["design"]["rows"]
        return cls(
            throw=CrankThrow(**record["throw"]),
            factors=tuple(
                Factor(
                    **given
                    | {
                        "levels": None if given["levels"] is None else tuple(given["levels"]),
                        "labels": tuple(given["labels"]),
                    }
                )
                for given in record["factors"]
            ),
            design=DesignChoice(
                **design | {"rows": None if rows is None else tuple(map(tuple, rows))}
            ),
            relations=record["relations"],
            constraints=tuple(record["constraints"]),
            material=Material(**record["material"]),
            **{name: record[name] for name in ("held_out", "seed", "accuracy", "stresses")},
        )

    @cached_property
    def planned(self) -> "PlannedStudy":
        """Its designs, listed on first use; errors as of `plan_designs`."""
        return plan_designs(self)

    @property
    def key(self) -> str:
        """Key of the study: changes with anything that changes its results."""
        return content_key(self.as_record())


@dataclass(frozen=True)
class PlannedDesign:
    """One design of a study.

    Attributes
    ----------
    role : str
        `RUN` (fitted) or `HELD_OUT` (for assessment).
    values : tuple of float
        Of the factors [SI]; of a choice the label's index.
    inputs : dict
        Its complete inputs, as JSON content: throw, material, accuracy, stresses.
    key : str
        Hash of the inputs and the model version.
    added : bool
        Whether it was added to the plan later.
    """

    role: str
    values: tuple[float, ...]
    inputs: dict[str, Any]
    key: str
    added: bool = False


@dataclass(frozen=True)
class ExcludedDesign:
    """A design that is not computed, and why; a random one was replaced by another."""

    values: tuple[float, ...]
    reason: str
    role: str = RUN


@dataclass(frozen=True)
class PlannedStudy:
    """The designs of a study.

    Attributes
    ----------
    plan : StudyPlan
    designs : tuple of PlannedDesign
        The runs, then the held-out ones.
    excluded : tuple of ExcludedDesign
    statement : str
        Description of the design, such as "fractional factorial 2^(4-1), resolution IV, 8 runs".
    remarks : tuple of str
        Remarks for the user, one sentence each.
    """

    plan: StudyPlan
    designs: tuple[PlannedDesign, ...]
    excluded: tuple[ExcludedDesign, ...]
    statement: str
    remarks: tuple[str, ...] = ()


def plan_designs(plan: StudyPlan) -> PlannedStudy:
    """List the designs of a study: the runs, then the held-out ones.

    Designs that violate a constraint or cannot be built are excluded. Of Latin
    hypercubes and Sobol sequences more points are drawn until the wanted number remains.

    Raises
    ------
    InputError
        If nothing, or too little, of the design can be built; the message states the first reason.
    """
    variants = plan.variants()
    if plan.design.kind in SPACE_FILLING:
        assert plan.design.runs is not None
        runs, excluded, drawn_runs = _draw_feasible_designs(
            plan, variants, RUN, plan.design.kind, plan.design.runs, RUN_STREAM
        )
        statement, remarks = space_filling_statement(plan.design.kind, plan.design.runs, plan.seed)
        if drawn_runs > len(runs):
            statement += f" of {drawn_runs} points drawn, {len(excluded)} of them excluded"
            spare = drawn_runs - len(runs) - len(excluded)
            statement += f" and {spare} not needed" if spare else ""
    else:
        design = fixed_design(plan.factors, plan.design)
        runs, excluded = _split(plan, RUN, design.runs, variants.at(design.runs))
        statement, remarks = design.statement, design.remarks
        if not runs:
            raise InputError(
                f"study.factors: none of the {len(design.runs)} designs can be used; reason for the first "
                f"excluded design: {excluded[0].reason.rstrip('.')}."
            )
        if excluded:
            statement += f", {len(excluded)} of them excluded"
            remarks = (
                *remarks,
                f"{len(excluded)} of {len(design.runs)} designs are excluded, so the others no longer "
                "have the balance that the design's name promises.",
            )
    held, held_excluded, _ = _draw_feasible_designs(
        plan, variants, HELD_OUT, "latin hypercube", plan.held_out, HELD_OUT_STREAM
    )
    return PlannedStudy(plan, (*runs, *held), (*excluded, *held_excluded), statement, remarks)


def _split(
    plan: StudyPlan, role: str, values: NDArray[np.float64], made: Sequence[Variant]
) -> tuple[tuple[PlannedDesign, ...], tuple[ExcludedDesign, ...]]:
    """Separate the designs that can be built from those that cannot."""
    designs, excluded = [], []
    for row, variant in zip(values.tolist(), made, strict=True):
        if variant.throw is None:
            excluded.append(ExcludedDesign(tuple(row), variant.reason, role))
        else:
            designs.append(planned_design(plan, role, tuple(row), variant.throw))
    return tuple(designs), tuple(excluded)


def _draw_feasible_designs(
    plan: StudyPlan, variants: Variants, role: str, kind: str, count: int, stream: int
) -> tuple[tuple[PlannedDesign, ...], tuple[ExcludedDesign, ...], int]:
    """Draw points until `count` of them are feasible designs; also return how many were drawn."""
    made: tuple[Variant, ...] = ()

    def draw(number: int) -> NDArray[np.float64]:
        return space_filling_points(plan.factors, kind, number, (plan.seed, stream))

    def possible(points: NDArray[np.float64]) -> NDArray[np.bool_]:
        nonlocal made
        made = variants.at(values_at(plan.factors, points))
        return np.array([variant.throw is not None for variant in made])

    found = draw_feasible_points(draw, possible, count, in_order=kind == "sobol")
    if found is None:
        first = next(variant.reason for variant in made if variant.throw is None)
        raise InputError(
            f"study.factors: fewer than {count} of the points drawn for the designs ({role}) can be "
            f"used; reason for the first excluded design: {first.rstrip('.')}."
        )
    # A design that can be built but was not taken belongs to neither.
    points, taken, impossible = found
    kept = np.flatnonzero(taken | impossible)
    values = values_at(plan.factors, points)[kept]
    designs, excluded = _split(plan, role, values, [made[place] for place in kept])
    return designs, excluded, len(points)


def planned_design(
    plan: StudyPlan, role: str, values: tuple[float, ...], throw: dict[str, Any]
) -> PlannedDesign:
    """Make a design of a study.

    Parameters
    ----------
    plan : StudyPlan
    role : str
        `RUN` or `HELD_OUT`.
    values : tuple of float
        Of the factors [SI].
    throw : dict
        The throw of the study with these values, as JSON content.
    """
    inputs = {"throw": throw, **plan.settings}
    return PlannedDesign(
        role, values, inputs, content_key(inputs | {"model_version": MODEL_VERSION})
    )
