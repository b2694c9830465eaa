"""The plan of a study: a base throw, factors, a design, and the resulting list of designs."""

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, field, replace
from functools import cached_property
from typing import Annotated, Any

import numpy as np

from crankbase.array_checks import Array, Flags
from crankbase.choices import check_choice, whole_number
from crankbase.errors import InputError
from crankbase.results import Quantity, Result, result
from crankbase.sentences import kept
from crankbase.summaries import frozen
from crankbase.units import is_unit
from fem.material import STEEL, Material
from geometry.throw import CrankThrow
from geometry.throw_dimensions import changed_record
from regression.plans.designs import (
    HELD_OUT_STREAM,
    RUN_STREAM,
    SPACE_FILLING,
    DesignChoice,
    check_ranges,
    draw_feasible_points,
    fixed_design,
    space_filling_points,
    space_filling_statement,
    values_at,
)
from regression.plans.factors import (
    FREE_NAME,
    Factor,
    ThrowField,
    field_value,
    rounded,
    throw_fields,
    unknown_field,
)
from regression.plans.moved_meshes import (
    ANCHOR_ACCURACY,
    MESHES,
    MOVED_MESH,
    NEW_MESH,
    Mesh,
    mesh_classes,
)
from regression.plans.relations import (
    EQUAL_WITHIN,
    Constraint,
    Expression,
    constraint_excess,
    constraint_violations,
    evaluate_expression,
    evaluation_order,
    read_constraint,
    read_expression,
    used_names,
)
from regression.records import HELD_OUT, MOVED, RUN, SLOPES, content_key

# Of a factor's range, for central differences of what follows from it.
SHIFT = 1e-5


@dataclass(frozen=True)
class Variant:
    """A throw from factor values, as its record; or None and the reason why there is none."""

    throw: dict[str, Any] | None
    reason: str = ""


@dataclass(frozen=True)
class Variants:
    """The throws that follow from a study's factors, relations, constraints and base throw.

    `units` has the SI unit of all quantities allowed in expressions; relations are in the order of
    calculation.
    """

    record: Mapping[str, Any]
    factors: tuple[Factor, ...]
    fields: Mapping[str, ThrowField]
    units: Mapping[str, str]
    relations: Mapping[str, Expression]
    constraints: tuple[Constraint, ...]

    @classmethod
    def of(
        cls,
        throw: CrankThrow,
        factors: tuple[Factor, ...],
        relations: Mapping[str, str],
        constraints: tuple[str, ...],
    ) -> "Variants":
        """Check names and units; `InputError` names the factor, relation or constraint that is wrong."""
        fields, record = throw_fields(throw), throw.model_dump(mode="json")
        names = [factor.name for factor in factors]
        for name in names:
            if names.count(name) > 1:
                raise InputError(f"study.factors.{name}: given twice; allowed is each factor once.")
        for path in relations:
            target = f"study.relations.{path}"
            if path not in fields:
                raise InputError(
                    f"{target}: unknown throw dimension; {unknown_field(path, fields, throw)}."
                )
            if fields[path].choices:
                raise InputError(
                    f"{target}: is a choice; allowed are fields that are quantities, because an expression "
                    "gives a number."
                )
            if path in names:
                raise InputError(
                    f"{target}: is a factor as well; allowed is either, because a relation fixes what a "
                    "factor varies."
                )
        units = {
            path: entry.unit
            for path, entry in fields.items()
            if not entry.choices and (field_value(record, path) is not None or path in relations)
        } | {factor.name: factor.unit for factor in factors if not factor.labels}
        read = {
            path: read_expression(text, f"study.relations.{path}", units)
            for path, text in relations.items()
        }
        limits = tuple(
            read_constraint(text, f"study.constraints[{place}]", units)
            for place, text in enumerate(constraints)
        )
        for factor in factors:
            _check_factor(factor, fields, throw, used_names(read.values()))
        ones = dict.fromkeys(units, np.array(1.0))
        for path, expression in read.items():
            evaluate_expression(expression, ones, units, fields[path].unit)  # refuses another unit
        ordered = {path: read[path] for path in evaluation_order(read)}
        return cls(record, factors, fields, units, ordered, limits)

    def at(self, values: Array) -> tuple[Variant, ...]:
        """Make the throws of factor values (n, k) [SI]; of a choice the label's index."""
        count = len(values)
        reasons: list[str | None] = [None] * count
        known = self._quantities(values)
        for path, expression in self.relations.items():
            results = np.broadcast_to(
                evaluate_expression(expression, known, self.units, self.units[path]), (count,)
            )
            known[path] = np.array([rounded(value) for value in results.tolist()])
            for place in np.flatnonzero(~np.isfinite(known[path])).tolist():
                reasons[place] = reasons[place] or (
                    f"the relation {path} = {expression.text!r} has no finite value"
                )
        for constraint in self.constraints:
            for place, reason in enumerate(
                constraint_violations(constraint, known, self.units, count)
            ):
                reasons[place] = reasons[place] or reason
        return tuple(
            self._variant(row, place, known, reasons[place])
            for place, row in enumerate(values.tolist())
        )

    def keep_constraints(self, values: Array) -> Flags:
        """Return which factor values (n, k) meet the constraints, whether throws can be built or not."""
        known = self._quantities(values)
        kept = np.ones(len(values), dtype=bool)
        for path, expression in self.relations.items():
            known[path] = evaluate_expression(expression, known, self.units, self.units[path])
        for constraint in self.constraints:
            kept &= constraint_excess(constraint, known, self.units) <= EQUAL_WITHIN
        return kept

    def fields_at(self, values: Array) -> dict[str, Array]:
        """Return all numbers of the throws of factor values (n, k), whether they can be built or not."""
        count = len(values)
        known = {
            path: np.full(count, float(base))
            for path in self.units
            if isinstance(base := field_value(self.record, path), int | float)
        } | {
            factor.name: column
            for factor, column in zip(self.factors, values.T, strict=True)
            if not factor.labels
        }
        for path, expression in self.relations.items():
            result = evaluate_expression(expression, known, self.units, self.units[path])
            known[path] = np.array(np.broadcast_to(result, (count,)))
        return known

    def beside(self, values: Array, place: int) -> tuple[Array, Array, float]:
        """Return the values with one factor smaller and larger, and half of the difference [SI]."""
        factor = self.factors[place]
        step = SHIFT * (factor.highest - factor.lowest)
        shift = step * np.eye(len(self.factors))[place]
        return values - shift, values + shift, step

    def _quantities(self, values: Array) -> dict[str, Array]:
        columns = {
            factor.name: column
            for factor, column in zip(self.factors, values.T, strict=True)
            if not factor.labels
        }
        used = used_names(
            (
                *self.relations.values(),
                *(side for constraint in self.constraints for side in constraint.sides),
            )
        )
        base = {
            path: np.array(float(field_value(self.record, path)))
            for path in used
            if path not in columns and path not in self.relations
        }
        return base | columns

    def _variant(
        self,
        row: list[float],
        place: int,
        known: Mapping[str, Array],
        reason: str | None,
    ) -> Variant:
        if reason is not None:
            return Variant(None, reason)
        changes: dict[str, Any] = {
            factor.name: factor.setting(value)
            for factor, value in zip(self.factors, row, strict=True)
            if factor.name in self.fields
        }
        changes |= {path: float(known[path][place]) for path in self.relations}
        try:
            throw = CrankThrow(**changed_record(self.record, changes))
        except InputError as error:
            return Variant(None, f"it cannot be built: {str(error).rstrip('.')}")
        return Variant(throw.model_dump(mode="json"))


def _check_factor(
    factor: Factor, fields: Mapping[str, ThrowField], throw: CrankThrow, used: set[str]
) -> None:
    name, entry = f"study.factors.{factor.name}", fields.get(factor.name)
    if entry is not None:
        unfit = next((label for label in factor.labels if label not in entry.choices), None)
        if unfit is not None or bool(factor.labels) != bool(entry.choices):
            chosen = unfit or kept(factor.range_text)
            allowed = ", ".join(entry.choices) or f"a range or levels in {entry.unit or 'no unit'}"
            raise InputError(f"{name}: given {chosen}; allowed is {allowed}.")
        if factor.unit != entry.unit:
            raise InputError(
                f"{name}: given in {factor.unit or 'no unit'}; allowed is {entry.unit or 'no unit'}."
            )
        return
    if factor.name not in used or factor.labels or factor.unit:
        raise InputError(
            f"{name}: unknown throw dimension, and no relation uses it as a ratio; "
            f"{unknown_field(factor.name, fields, throw)}."
        )
    if not FREE_NAME.fullmatch(factor.name) or is_unit(factor.name):
        raise InputError(
            f"{name}: is the name of a unit; allowed for a ratio is a name of letters, digits and "
            "underscores that is none."
        )


# Raise when a change of the model changes results: stored results of older versions are not used.
MODEL_VERSION = 7
# The same for answers on moved meshes, before they are scaled: others have keys of their own.
MOVED_VERSION = 3


@frozen("study: key", "factors: names", "design: design.kind", "held_out", "accuracy")
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
    accuracy : float
        Relative accuracy of each design's axial compliance, 0.001 to 0.1.
    stresses : bool
        Whether the fillet stresses are computed as well.
    slopes : bool
        Whether the slopes of the responses at the runs are computed, and fitted, as well.
    form : str, optional
        Form of all equations; by default that with the smallest held-out errors is chosen for each.
    mesh : {"new", "moved"}
        Whether each design is meshed anew, or designs of one topology have one coarse mesh that is moved, and
        a few designs, the anchors, also meshes of their own, to which all answers are scaled
        (`regression.runs.moved_answers`).

    Raises
    ------
    InputError
        If a factor, relation or constraint names something unknown or does not fit the others, or no
        design is held out.
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
    slopes: bool = False
    form: str | None = None
    mesh: Mesh = NEW_MESH

    def __post_init__(self) -> None:
        check_choice("study.mesh", self.mesh, MESHES, "a mesh is made, or another one is moved")
        if self.stresses and self.mesh == MOVED_MESH:
            raise InputError(
                f'study.mesh: given "{MOVED_MESH}" with study.stresses; allowed is "{NEW_MESH}", because '
                "stresses at fillets need meshes of their own."
            )
        whole_number("study.held_out", self.held_out, 1, "these designs judge the fits")
        if all(factor.labels for factor in self.factors):
            raise InputError(
                f"study.factors: given {', '.join(self.names) or 'none'}; allowed is at least one factor "
                "that is a number, because an equation needs something to vary in."
            )
        if self.design.kind in SPACE_FILLING:
            check_ranges(self.factors, self.design.kind)
        self.variants()  # refuses what does not fit together

    def __hash__(self) -> int:
        # Mappings among the fields have none.
        return hash(self.key)

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the factors."""
        return tuple(factor.name for factor in self.factors)

    def variants(self) -> Variants:
        """Return the function that makes throws of factor values."""
        return Variants.of(self.throw, self.factors, self.relations, self.constraints)

    @cached_property
    def moved(self) -> tuple[str, ...]:
        """Fields of the throw that follow from factors that are numbers."""
        fields = throw_fields(self.throw)
        numbers = [factor.name for factor in self.factors if not factor.labels]
        return tuple(sorted({*self.relations, *(name for name in numbers if name in fields)}))

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
            # Without these as before there were any, so that studies keep their keys.
            **({"slopes": True} if self.slopes else {}),
            **({"form": self.form} if self.form else {}),
            **({"mesh": self.mesh} if self.mesh != NEW_MESH else {}),
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
                    **factor
                    | {
                        "levels": None if factor["levels"] is None else tuple(factor["levels"]),
                        "labels": tuple(factor["labels"]),
                    }
                )
                for factor in record["factors"]
            ),
            design=DesignChoice(
                **design | {"rows": None if rows is None else tuple(map(tuple, rows))}
            ),
            relations=record["relations"],
            constraints=tuple(record["constraints"]),
            material=Material(**record["material"]),
            slopes=record.get("slopes", False),
            form=record.get("form"),
            mesh=record.get("mesh", NEW_MESH),
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
    """One design of a study, `RUN` (fitted) or `HELD_OUT` (for assessment).

    `values` of the factors are in SI units, of a choice the label's index; `inputs` its complete inputs
    as JSON content, `key` the hash of these and the model version. `added`: whether it was added to the
    plan later. `mesh_class`: of a design on a moved mesh, the number of its topology, from 1. `ordinary`: of
    an anchor, key and inputs of the same throw on a mesh of its own.
    """

    role: str
    values: tuple[float, ...]
    inputs: dict[str, Any]
    key: str
    added: bool = False
    mesh_class: int | None = None
    ordinary: tuple[str, Mapping[str, Any]] | None = None


@result("role", "reason", eq=True)
class ExcludedDesign(Result):
    """A design without a result, and why; of those not computed a random one was replaced by another."""

    values: Annotated[tuple[float, ...], Quantity(".value_units")]
    reason: str
    role: str = RUN


@dataclass(frozen=True)
class PlannedStudy:
    """The designs of a study: the runs, then the held-out ones; the statement describes the design."""

    plan: StudyPlan
    designs: tuple[PlannedDesign, ...]
    excluded: tuple[ExcludedDesign, ...]
    statement: str
    remarks: tuple[str, ...] = ()

    @property
    def tasks(self) -> dict[str, Mapping[str, Any]]:
        """What is computed: inputs by key, of the designs and of anchors on meshes of their own."""
        ordinary = (design.ordinary for design in self.designs if design.ordinary)
        return {design.key: design.inputs for design in self.designs} | dict(ordinary)


def plan_designs(plan: StudyPlan) -> PlannedStudy:
    """List the designs of a study: the runs, then the held-out ones.

    Designs that violate a constraint or cannot be built are excluded. Of Latin hypercubes and Sobol
    sequences more points are drawn until the wanted number remains. `InputError` with the first reason
    if too little can be built.
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
                f"{len(excluded)} of {len(design.runs)} runs are excluded, so the others no longer "
                "have the balance that the design's name promises.",
            )
    statement += ", with slopes" if plan.slopes else ""
    held, held_excluded, _ = _draw_feasible_designs(
        plan, variants, HELD_OUT, "latin hypercube", plan.held_out, HELD_OUT_STREAM
    )
    designs = with_meshes(plan, (*runs, *held))
    if plan.mesh != NEW_MESH:
        remarks = (*remarks, _mesh_remark(designs))
    return PlannedStudy(plan, designs, (*excluded, *held_excluded), statement, remarks)


def _split(
    plan: StudyPlan, role: str, values: Array, made: Sequence[Variant]
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

    def draw(number: int) -> Array:
        return space_filling_points(plan.factors, kind, number, (plan.seed, stream))

    def possible(points: Array) -> Flags:
        nonlocal made
        made = variants.at(values_at(plan.factors, points))
        return np.array([variant.throw is not None for variant in made])

    drawn = draw_feasible_points(draw, possible, count, in_order=kind == "sobol")
    if drawn is None:
        first = next(variant.reason for variant in made if variant.throw is None)
        raise InputError(
            f"study.factors: fewer than {count} of the points drawn for the designs ({role}) can be "
            f"used; reason for the first excluded design: {first.rstrip('.')}."
        )
    # A design that can be built but was not taken belongs to neither.
    points, taken, impossible = drawn
    kept = np.flatnonzero(taken | impossible)
    values = values_at(plan.factors, points)[kept]
    designs, excluded = _split(plan, role, values, [made[place] for place in kept])
    return designs, excluded, len(points)


def planned_design(
    plan: StudyPlan, role: str, values: tuple[float, ...], throw: dict[str, Any]
) -> PlannedDesign:
    """Make a design of a study from factor values [SI] and the throw with these, as JSON content."""
    inputs = {"throw": throw, **plan.settings}
    if plan.slopes and role == RUN:
        inputs[SLOPES] = list(plan.moved)
    return PlannedDesign(role, values, inputs, _design_key(inputs))


def with_meshes(
    plan: StudyPlan, designs: tuple[PlannedDesign, ...], added: tuple[PlannedDesign, ...] = ()
) -> tuple[PlannedDesign, ...]:
    """Give designs on meshes of their own the moved meshes that their plan wishes for.

    Classes, references and anchors follow from the designs of the plan alone, so that they are the same
    whatever is computed already; added designs only take part in them.
    """
    if plan.mesh == NEW_MESH:
        return (*designs, *added)
    numbers = [place for place, factor in enumerate(plan.factors) if not factor.labels]
    records = [design.inputs["throw"] for design in (*designs, *added)]
    values = np.array([design.values for design in designs])[:, numbers]
    classes = mesh_classes(records, values, plan.accuracy)
    places = {place: known for known in classes for place in known.members}
    planned = []
    for place, design in enumerate((*designs, *added)):
        if place not in places:
            planned.append(design)
            continue
        mesh_class = places[place]
        moved = {"throw": mesh_class.throw, "paths": list(plan.moved), "version": MOVED_VERSION}
        inputs = design.inputs | {MOVED: moved}
        ordinary = None
        if place in mesh_class.anchors:
            alone = {key: kept for key, kept in design.inputs.items() if key not in (SLOPES, MOVED)}
            alone["accuracy"] = min(plan.accuracy, ANCHOR_ACCURACY)
            ordinary = (_design_key(alone), alone)
        planned.append(
            replace(
                design,
                inputs=inputs,
                key=_design_key(inputs),
                mesh_class=mesh_class.number,
                ordinary=ordinary,
            )
        )
    return tuple(planned)


def _mesh_remark(designs: Sequence[PlannedDesign]) -> str:
    classes = [design.mesh_class for design in designs if design.mesh_class is not None]
    if not classes:
        return "No mesh is moved, because no topology has designs enough to repay its anchors."
    anchors = sum(design.ordinary is not None for design in designs)
    topologies = "1 topology" if max(classes) == 1 else f"{max(classes)} topologies"
    return (
        f"{len(classes)} of {len(designs)} designs have moved meshes, those of {topologies}; "
        f"anchors, with meshes of their own too: {anchors}."
    )


def _design_key(inputs: Mapping[str, Any]) -> str:
    return content_key({**inputs, "model_version": MODEL_VERSION})
