"""The results of a study as arrays: its own designs, and imported results."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Annotated, Any

import numpy as np

from crankbase.array_checks import Array, Flags
from crankbase.diagrams import display_unit, draw_dots, legend_inside, new_axes, write_title
from crankbase.errors import InputError
from crankbase.frames import Axes, table
from crankbase.model import field_extra
from crankbase.results import Internal, Quantity, Result, result
from fem.response_table import RESPONSES
from geometry.throw import CrankThrow
from regression.plans.factors import Factor
from regression.plans.plan import ExcludedDesign, PlannedDesign, StudyPlan
from regression.plots import design_dots, factor_size, label_factor_axis, response_text
from regression.records import HELD_OUT, MEASURED, ExtraRow, Outcome
from regression.runs.moved_answers import ScaledAnswers, is_moved, scaled_answers
from regression.throw_values import same_dimension

Arrays = Mapping[str, Annotated[Array, Quantity("1")]]

DONE, WAITING = "done", "waiting"
NOT_COMPUTED = "not computed yet"


@dataclass(frozen=True, kw_only=True)
class StudyRow(ExtraRow):
    """One design of a study, or one row imported into it, with or without a result.

    Attributes
    ----------
    status : str
        "done", "failed", "lost" (with its worker) or "waiting".
    reason : str
        Why there is no result.
    source : str
        Origin of an imported row; empty for the study's own.
    slopes : mapping
        Response to its slopes over the factors, d(response) / d(factor) [SI] by factor, where known.
    slope_errors : mapping
        Response to the estimated error of its slopes, as shares d ln(response) / d ln(dimension).
    mesh_class : int or None
        Of a study on moved meshes: the number of its topology.
    mesh : str
        How its mesh was made: "velocities" or "elastic" if it was moved, "anchor" if its answers are those of
        a mesh of its own besides, "new" if that alone; "" in studies without moved meshes, and of imported
        rows.
    mesh_quality : float or None
        Mean ratio of the flattest element of a moved mesh.
    """

    status: str
    seconds: float = 0.0
    unknowns: int | None = None
    reason: str = ""
    slopes: Mapping[str, Mapping[str, float]] = field(default_factory=dict)
    slope_errors: Mapping[str, float] = field(default_factory=dict)
    mesh_class: int | None = None
    mesh: str = ""
    mesh_quality: float | None = None

    @property
    def mesh_cells(self) -> tuple[int | None, str | None, float | None]:
        """Class, kind and quality of its mesh."""
        return self.mesh_class, self.mesh or None, self.mesh_quality


@result("values", "responses")
class DesignTable(Result):
    """Designs that have a result, imported ones included, as arrays.

    Attributes
    ----------
    values : (n, k) array
        Of the factors [SI]; for a choice the index of its label.
    held_out : (n,) array of bool
        Which of them are not used in fits.
    responses, errors : dict
        Response name to (n,) array: [SI], and estimated relative errors, of responses for which every
        row has one.
    """

    values: Annotated[Array, Quantity(".value_units")]
    held_out: Annotated[Flags, Quantity()]
    responses: Annotated[Arrays, Quantity(".response_units")]
    errors: Annotated[Arrays, Quantity("1")]

    @property
    def response_units(self) -> dict[str, str]:
        """Unit of each response."""
        known = {name: kind.unit for name, kind in RESPONSES.items()}
        return {name: known.get(name) or "1" for name in self.responses}


@result("study: plan.key", "designs: values", "responses", "failures", "excluded")
class StudyTable(DesignTable):
    """Results of a study as arrays.

    Attributes
    ----------
    dimensions : dict
        Numeric field of the throw to (n,) array [SI], as built.
    outlines : dict
        Text field of the throw to its n values.
    seconds : (n,) array
        Time of each [s]; 0 for imported ones.
    failures, excluded : tuple of ExcludedDesign
        Designs without a result; designs that the plan excluded because they cannot be built.
    computed : int
        Number of designs computed now, not read from the store.
    added : int
        Runs added to the plan's, with or without a result.
    extra : tuple of ExtraRow
        All imported rows, the measured ones too.
    damaged : dict of str to str
        Skipped rows of the store, by design key or position, and their faults.
    slopes : dict
        Response to its slopes (n, k) over the factors [SI], NaN where there is none; of responses that have
        any.
    slope_errors : dict
        Response to the estimated errors (n,) of its slopes as shares d ln(response) / d ln(dimension).
    rows : tuple of StudyRow
        Everything above row by row, in order.
    """

    plan: Internal[StudyPlan]
    dimensions: Internal[dict[str, Array]]
    outlines: Internal[dict[str, tuple[str, ...]]]
    seconds: Internal[Array]
    failures: Internal[tuple[ExcludedDesign, ...]]
    excluded: Internal[tuple[ExcludedDesign, ...]] = ()
    computed: Internal[int] = 0
    added: Internal[int] = 0
    extra: Internal[tuple[ExtraRow, ...]] = ()
    rows: Internal[tuple[StudyRow, ...]] = ()
    damaged: Internal[Mapping[str, str]] = field(default_factory=dict)
    slopes: Internal[Mapping[str, Array]] = field(default_factory=dict)
    slope_errors: Internal[Mapping[str, Array]] = field(default_factory=dict)

    def plot(
        self, axes: Axes | None = None, *, response: str | None = None, factor: str | None = None
    ) -> Axes:
        """Draw a response of all designs over one of the factors.

        Parameters
        ----------
        axes : matplotlib.axes.Axes, optional
            New ones by default.
        response : str, optional
            A column of `responses`; the first by default.
        factor : str, optional
            The first by default.

        Raises
        ------
        InputError
            If the study has no such response or factor.
        """
        column = _one_of("response", response, list(self.responses))
        names = list(self.plan.names)
        place = names.index(_one_of("factor", factor, names))
        chosen = self.plan.factors[place]
        kind = RESPONSES.get(column)
        symbol, unit = (column.replace("_", " "), "") if kind is None else (kind.symbol, kind.unit)
        axes = new_axes(axes)
        x = self.values[:, place] / factor_size(chosen.unit, chosen.labels)
        for dots in design_dots(x, self.responses[column] / display_unit(unit)[1], self.held_out):
            draw_dots(axes, dots)
        label_factor_axis(axes, chosen.name, chosen.unit, chosen.labels)
        axes.set_ylabel(response_text(symbol, unit))
        write_title(axes, f"Designs of the study, {column.replace('_', ' ')}")
        legend_inside(axes)
        return axes

    def to_pandas(self) -> Any:
        """Return a table of the designs that have a result, one a row.

        Returns
        -------
        pandas.DataFrame
            ``held_out``, the factors (choices as their labels), the responses, their estimated
            relative errors as "NAME error", slopes as "NAME per FACTOR" (missing where there is none),
            of moved meshes ``mesh_class``, ``mesh`` and ``mesh_quality``, and ``seconds``; units are in
            ``frame.attrs["units"]``.

        Raises
        ------
        MissingLibraryError
            If pandas is not installed.
        """
        columns: dict[str, tuple[Any, str]] = {"held_out": (self.held_out, "")}
        for place, factor in enumerate(self.plan.factors):
            values = self.values[:, place]
            if factor.labels:
                columns[factor.name] = [factor.setting(value) for value in values.tolist()], ""
            else:
                columns[factor.name] = values, factor.unit or "1"
        units = self.response_units
        columns |= {name: (values, units[name]) for name, values in self.responses.items()}
        columns |= {f"{name} error": (values, "1") for name, values in self.errors.items()}
        for place, factor in enumerate(self.plan.factors):
            columns |= {
                slope_name(name, factor.name): (slopes[:, place], slope_unit(name, factor))
                for name, slopes in self.slopes.items()
                if not factor.labels
            }
        cells = [row.mesh_cells for row in self.rows if row.status == DONE and row.role != MEASURED]
        if any(kind for _, kind, _ in cells):
            names = ("mesh_class", "mesh", "mesh_quality")
            columns |= {
                n: (list(c), "") for n, c in zip(names, zip(*cells, strict=True), strict=True)
            }
        return table(columns | {"seconds": (self.seconds, "s")})


def _one_of(argument: str, chosen: str | None, names: list[str]) -> str:
    """Return the given name, or the first one."""
    if not names or (chosen is not None and chosen not in names):
        raise InputError(
            f"{argument}: given {chosen!r}; allowed are {', '.join(names) or 'none'}, because the study "
            "has these."
        )
    return names[0] if chosen is None else chosen


PER = " per "


def slope_name(response: str, factor: str) -> str:
    """Name the column of a response's slopes over a factor."""
    return f"{response}{PER}{factor}"


def slope_unit(response: str, factor: Factor) -> str:
    """Return the SI unit of a response's slope over a factor."""
    unit = RESPONSES[response].unit or "1"
    return f"{unit} per {factor.unit}" if factor.unit else unit


def throw_dimensions(throw: Mapping[str, Any]) -> dict[str, float]:
    """Numbers among a throw's own fields (JSON content), by name; missing fields are left out."""
    return {
        name: float(throw[name])
        for name, info in CrankThrow.model_fields.items()
        if field_extra(info, "unit") is not None and isinstance(throw.get(name), int | float)
    }


def throw_outlines(throw: Mapping[str, Any]) -> dict[str, str]:
    """Return the text values among a throw's own fields, by name."""
    return {
        name: throw[name] for name in CrankThrow.model_fields if isinstance(throw.get(name), str)
    }


def study_table(
    plan: StudyPlan,
    designs: Sequence[PlannedDesign],
    outcomes: Mapping[str, Outcome],
    extra: Iterable[ExtraRow] = (),
    excluded: Sequence[ExcludedDesign] = (),
    computed: int = 0,
    damaged: Mapping[str, str] | None = None,
) -> StudyTable:
    """Combine a study's designs with their outcomes by key, and the rows imported into it.

    An extra row at the same values as a design with a result is left out: the study's own result has
    priority. So is one at the same values as an earlier row: the fit must not be assessed by data used
    in it. `computed` designs are of now; `damaged` has the faults of skipped rows of the store, by
    design key or position.
    """
    damaged = dict(damaged or {})
    extra = tuple(extra)
    scaled = scaled_answers(designs, outcomes)
    outcomes = scaled.outcomes
    computed_rows = [_own_row(design, outcomes.get(design.key), damaged) for design in designs]
    if plan.slopes:
        computed_rows = _with_slopes(plan, designs, computed_rows, scaled)
    taken = [row.values for row in computed_rows if row.status == DONE]
    imported = []
    for row in extra:
        if row.role != MEASURED:
            if any(_equal(row.values, values) for values in taken):
                continue
            taken.append(row.values)
        imported.append(StudyRow(status=DONE, **vars(row)))
    rows = (*computed_rows, *imported)
    good = [row for row in rows if row.status == DONE and row.role != MEASURED]
    sloped = dict.fromkeys(name for row in good for name in row.slopes)
    return StudyTable(
        plan=plan,
        values=np.array([row.values for row in good], dtype=float).reshape(
            len(good), len(plan.factors)
        ),
        held_out=np.array([row.role == HELD_OUT for row in good], dtype=bool),
        responses={n: np.array(v) for n, v in _columns([row.responses for row in good]).items()},
        errors={n: np.array(v) for n, v in _columns([row.errors for row in good]).items()},
        dimensions={n: np.array(v) for n, v in _columns([row.dimensions for row in good]).items()},
        outlines={n: tuple(v) for n, v in _columns([row.outlines for row in good]).items()},
        seconds=np.array([row.seconds for row in good], dtype=float),
        failures=tuple(
            ExcludedDesign(row.values or (), row.reason, row.role)
            for row in computed_rows
            if row.reason
        ),
        excluded=tuple(excluded),
        computed=computed,
        added=sum(design.added for design in designs),
        extra=extra,
        rows=rows,
        damaged=damaged,
        slopes={
            name: np.array(
                [
                    [row.slopes.get(name, {}).get(over, np.nan) for over in plan.names]
                    for row in good
                ]
            )
            for name in sloped
        },
        slope_errors={
            name: np.array([row.slope_errors.get(name, np.nan) for row in good]) for name in sloped
        },
    )


def _own_row(
    design: PlannedDesign, outcome: Outcome | None, damaged: Mapping[str, str]
) -> StudyRow:
    throw = design.inputs["throw"]
    known = outcome or Outcome(design.key, design.inputs, None, NOT_COMPUTED, 0.0)
    mesh, quality = str(known.mesh.get("tier", "")), known.mesh.get("quality")
    reason = known.reason or ""
    if design.key in damaged:
        reason = f"its row in the store is damaged ({damaged[design.key]}): the next run computes it again"
    return StudyRow(
        role=design.role,
        status=WAITING if outcome is None else outcome.status,
        values=design.values,
        dimensions=throw_dimensions(throw),
        outlines=throw_outlines(throw),
        responses=known.responses or {},
        errors=known.errors,
        seconds=known.seconds,
        unknowns=known.unknowns,
        reason=reason,
        source="",
        mesh_class=design.mesh_class,
        mesh="anchor" if design.ordinary and is_moved(outcome) else mesh,
        mesh_quality=None if quality is None else float(quality),
    )


def _with_slopes(
    plan: StudyPlan,
    designs: Sequence[PlannedDesign],
    rows: Sequence[StudyRow],
    scaled: ScaledAnswers,
) -> list[StudyRow]:
    """Add the slopes over the factors: each is the sum over the dimensions that the factor changes."""
    variants, values = plan.variants(), np.array([design.values for design in designs])
    known = [scaled.outcomes.get(design.key) for design in designs]
    trends = [scaled.trends.get(design.key, {}) for design in designs]
    slopes: list[dict[str, dict[str, float]]] = [{} for _ in designs]
    for place, factor in enumerate(plan.factors):
        if factor.labels:
            continue
        less, more, step = variants.beside(values, place)
        low, high = variants.fields_at(less), variants.fields_at(more)
        changes = {path: (high[path] - low[path]) / (2.0 * step) for path in plan.moved}
        sizes = {path: 0.5 * (high[path] + low[path]) for path in plan.moved}
        for row, outcome in enumerate(known):
            moved = [path for path in plan.moved if changes[path][row]]
            for name, shares in (outcome.slopes if outcome else {}).items():
                if all(path in shares for path in moved):
                    terms = (shares[path] * changes[path][row] / sizes[path][row] for path in moved)
                    share = float(sum(terms))
                    if name in trends[row]:
                        share += float(trends[row][name][place])
                    slopes[row].setdefault(name, {})[factor.name] = (
                        rows[row].responses[name] * share
                    )
    return [
        replace(row, slopes=row_slopes, slope_errors=outcome.slope_errors if outcome else {})
        for row, row_slopes, outcome in zip(rows, slopes, known, strict=True)
    ]


def _equal(first: tuple[float, ...] | None, other: tuple[float, ...] | None) -> bool:
    return (
        first is not None
        and other is not None
        and all(same_dimension(a, b) for a, b in zip(first, other, strict=True))
    )


def _columns(rows: Sequence[Mapping[str, Any]]) -> dict[str, list[Any]]:
    """Values of what every row has, in the order of the first."""
    names = [name for name in rows[0] if all(name in row for row in rows)] if rows else []
    return {name: [row[name] for row in rows] for name in names}
