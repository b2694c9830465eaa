"""How an engine's vibration changes with its dimensions and elements.

Chains are made again with one input a little smaller and larger. The throws are not meshed again: they change
by the slopes of their finite elements' solutions (`fem.sensitivities`).
"""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from typing import Annotated, Any

import numpy as np

from crankbase.array_checks import Array
from crankbase.diagrams import draw_rows, new_axes, write_title
from crankbase.errors import InputError
from crankbase.frames import Axes, table
from crankbase.results import Quantity, Result, Speed, result
from crankbase.table import Column, Table
from crankfem.analyses.shaft.chains import (
    damped_engine_chain,
    engine_axial_chain,
    engine_throw_inertias,
    engine_torsional_chain,
)
from crankfem.analyses.shaft.sources import compliances_in_shaft
from crankfem.analyses.shaft.throw_analyses import crank_analyses
from crankfem.analyses.vibration.chain_answers import EngineChains
from crankfem.analyses.vibration.engine_excitation import engine_harmonics
from crankfem.analyses.vibration.engine_limits import limit_findings
from crankfem.analyses.vibration.modes import SourceResult
from crankfem.files.engine.engine_file import EngineFile
from crankfem.files.sections.crank_throws import PLAIN
from dynamics.assessment.verdict import LimitCheck
from dynamics.excitation.cylinders import CylinderHarmonics
from fem.analysis import ThrowAnalysis
from fem.superelement import ShaftCompliances, shaft_compliances
from geometry.boundary_motion import STEP

# Sections whose numbers are varied, besides the throws; the second ones change the forces of the cylinders.
ELEMENTS = (
    *("flywheel", "free_end", "torsional_damper", "axial_damper", "thrust_bearing", "bearings"),
    *("driven", "damping"),
)
MOVING_PARTS = ("rod", "piston")
# Of an input, for central differences of smooth functions.
SHARE = 1e-3
# What changes nothing by more than this share of one per cent is left out.
LEAST = 1e-6
Share = Annotated[float | None, Quantity("1", "change in per cent for one per cent of the input")]


@result("field", "torsional", "axial", "limit")
class InputSlope(Result):
    """Changes with one input: of the crankshaft's own first frequencies, and of the use of the worst limit.

    A critical speed changes as the frequency of its mode. None where there is no such mode or limit.
    """

    field: str
    torsional: Share
    axial: Share
    limit: Share


@result("limit", "place", "speed", "rows")
class VibrationSlopes(Result):
    """How an engine's vibration changes with its inputs, those first that change the worst limit most.

    Attributes
    ----------
    limit, place : str or None
        The worst limit of the verdict, whose use at `speed` is meant: for small changes that of the largest,
        too. None without one.
    modes : dict of str to int
        By kind, the number of the mode whose frequency is meant: the crankshaft's own first.
    left_out : dict
        Dimensions of throws without slopes, and the reason.
    """

    limit: str | None
    place: str | None
    speed: Speed | None
    modes: Annotated[dict[str, int], Quantity("1")]
    rows: tuple[InputSlope, ...]
    left_out: dict[str, str]

    def __getitem__(self, field: str) -> InputSlope:
        """Return the slopes over one input, such as "flywheel.inertia".

        Raises
        ------
        InputError
            If it has none.
        """
        for row in self.rows:
            if row.field == field:
                return row
        why = self.left_out.get(field, "nothing here changes with others")
        raise InputError(
            f"field: given {field!r}; allowed are {', '.join(row.field for row in self.rows)}, because {why}."
        )

    def parts(self) -> Iterator[Table | str]:
        """Write the slopes as a table."""
        at = "" if self.limit is None else f"; worst limit: {self.limit}, {self.place}"
        yield Table.of_records(
            f"Change in per cent for one per cent of an input{at}",
            self.rows,
            (Column("input", words=True), lambda row: row.field),
            (Column(self._frequency("torsional"), decimals=3), lambda row: row.torsional),
            (Column(self._frequency("axial"), decimals=3), lambda row: row.axial),
            (Column("limit's use", decimals=3), lambda row: row.limit),
            main=True,
        )

    def _frequency(self, kind: str) -> str:
        mode = self.modes.get(kind, 1)
        return f"first {kind} frequency" if mode == 1 else f"frequency of {kind} mode {mode}"

    def plot(self, axes: Axes | None = None) -> Axes:
        """Draw the changes of the worst limit's use, or of the first torsional frequency without a limit."""
        chosen = "torsional" if self.limit is None else "limit"
        shares = {row.field: getattr(row, chosen) for row in self.rows}
        known = {field: share for field, share in shares.items() if share is not None}
        axes = new_axes(axes, height=1.2 + 0.3 * len(known))
        draw_rows(axes, [*known], [*known.values()], "per cent for one per cent of the input")
        title = self._frequency("torsional")
        write_title(axes, self.limit or f"{title[0].upper()}{title[1:]}")
        return axes

    def to_pandas(self) -> Any:
        """Return a table, a row for each input.

        Raises
        ------
        MissingLibraryError
            If pandas is not installed.
        """
        shares = {
            name: ([getattr(row, name) for row in self.rows], "1")
            for name in ("torsional", "axial", "limit")
        }
        return table({"field": ([row.field for row in self.rows], ""), **shares}).set_index("field")


@dataclass(frozen=True)
class _Shaft:
    """What the chains of an engine are made of."""

    engine_file: EngineFile
    axial: Array
    torsional: Array
    masses: Array
    inertias: Array
    compliances: ShaftCompliances
    harmonics: CylinderHarmonics | None


@dataclass(frozen=True)
class _Model:
    """The answers of an engine whose inputs are changed."""

    analyses: Mapping[str, ThrowAnalysis]
    axial: SourceResult
    torsional: SourceResult
    check: LimitCheck | None

    def answers(self, shaft: _Shaft) -> Array:
        """Frequencies of the crankshaft's own first modes [Hz], the worst limit's use; NaN for none.

        A mode keeps its number where inputs change it.
        """
        file = shaft.engine_file
        inertias = engine_throw_inertias(file, shaft.inertias)
        chains = (
            engine_axial_chain(file, shaft.axial, shaft.masses),
            engine_torsional_chain(file, shaft.torsional, inertias),
        )
        pulled, cranks = (
            replace(chosen, compliances=compliances, chain=chain, modes=chain.chain.modes())
            for chosen, compliances, chain in zip(
                (self.axial, self.torsional),
                (shaft.axial, shaft.torsional),
                chains,
                strict=True,
            )
        )
        used = None
        if self.check is not None and shaft.harmonics is not None:
            damped = damped_engine_chain(file, chains[0]), damped_engine_chain(file, chains[1])
            engine = EngineChains(file, pulled, chains[1], damped, shaft.compliances)
            speeds = np.array([self.check.worst_speed])
            for limit, curve in limit_findings(file, *engine.at(shaft.harmonics, speeds)):
                if (limit.name, curve.name) == (self.check.limit.name, self.check.curve.name):
                    # What is permitted at this speed does not change with the inputs.
                    used = float(curve.values[0]) / self.check.permitted
        return np.array(
            [
                *(
                    None if chosen.first_mode is None else new.modes.frequencies[chosen.first_mode]
                    for chosen, new in ((self.torsional, cranks), (self.axial, pulled))
                ),
                used,
            ],
            dtype=float,
        )


def vibration_slopes(
    engine_file: EngineFile,
    analyses: Mapping[str, ThrowAnalysis],
    shaft: ShaftCompliances,
    axial: SourceResult,
    torsional: SourceResult,
    check: LimitCheck | None,
) -> VibrationSlopes:
    """Find how the vibration of an engine changes with its dimensions, inertias, stiffnesses and dampings.

    Each number of the throws, of the elements' sections and of the moving parts is varied by itself. The
    throws' relative changes are those of finite elements, whatever the source of their compliances.

    Parameters
    ----------
    analyses : mapping
        Of the throws by name.
    axial, torsional : SourceResult
        The chains with the chosen compliances.
    check : LimitCheck or None
        The limit whose use is meant; None if nothing is forced.
    """
    cranks = crank_analyses(engine_file, analyses)
    parts = _Shaft(
        engine_file,
        axial.compliances,
        torsional.compliances,
        np.array([crank.mass for crank in cranks]),
        np.array([crank.masses.inertia_about_shaft for crank in cranks]),
        shaft,
        None if check is None else engine_harmonics(engine_file),
    )
    model = _Model(analyses, axial, torsional, check)
    left_out: dict[str, str] = {}
    slopes = {
        field: (high - low) / (0.5 * (high + low)) / (2.0 * step)
        for field, step, low, high in (
            *_over_sections(parts, model, left_out),
            *_over_throws(parts, model, left_out),
        )
    }
    rows = [
        InputSlope(field, *(None if np.isnan(share) else float(share) for share in shares))
        for field, shares in slopes.items()
        if np.any(np.abs(shares) > LEAST)
    ]
    rows.sort(key=lambda row: -abs(row.limit or 0.0) if check else -abs(row.torsional or 0.0))
    numbers = {
        kind: chosen.first_mode - chosen.modes.rigid + 1
        for kind, chosen in (("torsional", torsional), ("axial", axial))
        if chosen.first_mode is not None
    }
    if check is None:
        return VibrationSlopes(None, None, None, numbers, tuple(rows), left_out)
    return VibrationSlopes(
        check.limit.name, check.curve.name, check.worst_speed, numbers, tuple(rows), left_out
    )


Sides = Iterator[tuple[str, float, Array, Array]]


def _over_sections(shaft: _Shaft, model: _Model, left_out: dict[str, str]) -> Sides:
    """The answers on both sides of each number of the sections, with the share of it."""
    file = shaft.engine_file

    def changed(section: str, name: str, value: float) -> _Shaft:
        moved = _of_file(shaft, file.changed(**{section: {name: value}}), section)
        if section != "bearings":
            return moved
        held = compliances_in_shaft(moved.engine_file, model.analyses)
        return _in_shaft(moved, shaft.compliances, held)

    for section in (*ELEMENTS, *MOVING_PARTS):
        fields = getattr(file, section)
        for name in () if fields is None else type(fields).model_fields:
            value, field = getattr(fields, name), f"{section}.{name}"
            if not isinstance(value, float) or not 0.0 < value < np.inf:
                continue
            try:
                low, high = (
                    model.answers(changed(section, name, value * factor))
                    for factor in (1.0 - SHARE, 1.0 + SHARE)
                )
            except InputError as error:
                left_out[field] = f"a little smaller or larger it is refused ({error})"
                continue
            yield field, SHARE, low, high


def _over_throws(shaft: _Shaft, model: _Model, left_out: dict[str, str]) -> Sides:
    """The answers on both sides of each dimension of the throws, with the share of it."""
    file = shaft.engine_file
    # As their changes are: corrected for discretization, if all of a throw is.
    beside = {
        crank: (each if each.corrected else each.discrete).superelement
        for crank, each in model.analyses.items()
    }
    for name, analysis in model.analyses.items():
        section = "throw" if name == PLAIN else f"throws.{name}"
        try:
            changes, without = analysis.changes_in_shaft
        except InputError as error:
            left_out[section] = str(error)
            continue
        left_out.update({f"{section}.{path}": reason for path, reason in without.items()})
        here = np.array([crank == name for crank in file.throw_names])
        for path, change in changes.items():
            held = [
                shaft_compliances(
                    [end if crank == name else beside[crank] for crank in file.throw_names],
                    crank_angles_deg=file.throw_angles_deg,
                    bearing_stiffness=file.main_bearings.stiffness,
                )
                for end in change.ends
            ]
            middle = _combined(held[0], held[1], lambda low, high: 0.5 * (low + high))
            sides = []
            try:
                for side, throw, compliances in zip(
                    (-STEP, STEP), change.throws, held, strict=True
                ):
                    sections: dict[str, Any] = {"throws": {name: throw}}
                    if name == PLAIN:
                        sections = {"throw": throw}
                    if path == "crank_radius":
                        sections["engine"] = {"stroke": file.engine.stroke * (1.0 + side)}
                    moved = _of_file(
                        _in_shaft(shaft, middle, compliances), file.changed(**sections), *sections
                    )
                    shares = 1.0 + side * here * np.array([[change.mass], [change.inertia]])
                    masses, inertias = shares * (shaft.masses, shaft.inertias)
                    sides.append(model.answers(replace(moved, masses=masses, inertias=inertias)))
            except InputError as error:
                left_out[f"{section}.{path}"] = (
                    f"a little smaller or larger it is refused ({error})"
                )
                continue
            yield f"{section}.{path}", STEP, sides[0], sides[1]


def _of_file(shaft: _Shaft, engine_file: EngineFile, *changed: str) -> _Shaft:
    """Return the shaft of a file with other sections."""
    harmonics = shaft.harmonics
    if harmonics is not None and set(changed) & {"engine", *MOVING_PARTS}:
        harmonics = engine_harmonics(engine_file)
    return replace(shaft, engine_file=engine_file, harmonics=harmonics)


def _in_shaft(shaft: _Shaft, before: ShaftCompliances, after: ShaftCompliances) -> _Shaft:
    """Change the compliances of the throws as others have changed: by the same share, the rest by as much."""
    return replace(
        shaft,
        axial=shaft.axial * after.axial / before.axial,
        torsional=shaft.torsional * after.torsional / before.torsional,
        compliances=_combined(
            shaft.compliances,
            _combined(before, after, lambda first, last: last - first),
            lambda value, step: value + step,
        ),
    )


def _combined(
    first: ShaftCompliances, second: ShaftCompliances, combine: Callable[[Array, Array], Array]
) -> ShaftCompliances:
    names = ("axial", "torsional", "influence", "tangential", "through")
    return ShaftCompliances(
        *(combine(getattr(first, name), getattr(second, name)) for name in names)
    )
