"""Axial and torsional vibration of an engine, with the compliances of any source."""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Annotated, Any, Literal

import numpy as np

from crankbase.array_checks import Array
from crankbase.choices import whole_number
from crankbase.diagrams import new_axes, write_title
from crankbase.errors import InputError
from crankbase.frames import Axes, table_of
from crankbase.quantity import RPM
from crankbase.results import Hertz, Internal, Number, Part, Quantity, Result, Speed, result
from crankbase.sentences import with_sentences
from crankbase.table import Column, Table
from crankfem.analyses.shaft.chains import (
    MOTION,
    engine_axial_chain,
    engine_throw_inertias,
    engine_torsional_chain,
)
from crankfem.analyses.shaft.sources import GIVEN, Sources, axial_sources, torsional_sources
from crankfem.analyses.shaft.throw_analyses import Analyses, crank_analyses
from crankfem.analyses.titles import short_name
from crankfem.analyses.vibration.engine_limits import assessment_end_speeds
from crankfem.files.engine.engine_file import EngineFile
from dynamics.chains.chain_modes import Modes
from dynamics.chains.engine_chains import CRANKSHAFT_MODE, FREE_END, EngineChain
from dynamics.critical import critical_speeds, engine_orders, major_orders, vector_sums
from dynamics.indices import at_most, within
from dynamics.plots.mode_shapes import draw_chain_shapes
from regression.formulas.axial_formulas import AXIAL_FORMULA_NAMES
from regression.formulas.torsional_formulas import TORSIONAL_FORMULA_NAMES

if TYPE_CHECKING:
    from fem.superelement import ShaftCompliances
    from regression.models.compliance_model import ComplianceModel

SHAPES_SHOWN = 3
# Resultant of the cylinders on a mode shape from which they count as acting together.
TOGETHER = 0.5
# Critical speeds below the running range in a table.
STARTED_SHOWN = 6
# No engine turns as slowly [rad/s]: critical speeds are sought from there on.
LEAST_SPEED = 1e-3
Kind = Literal["axial", "torsional"]


@with_sentences
@dataclass(frozen=True)
class SourceResult:
    """A chain with the compliances of one source, and its modes.

    Attributes
    ----------
    source : str
        "fe", "fe pinned", "regression" or a formula's name.
    compliances : (n,) array
        Of each throw [m/N or rad/(N m)].
    remark : str
        Remarks on the use of the source.
    """

    source: str
    compliances: Array
    chain: EngineChain
    modes: Modes
    remark: str

    @property
    def elastic_frequencies(self) -> Array:
        """Natural frequencies without rigid-body modes [Hz]."""
        return self.modes.elastic_frequencies

    @cached_property
    def first_mode(self) -> int | None:
        """Index of the lowest mode of the crankshaft itself; see `EngineChain.first_mode`."""
        return self.chain.first_mode(self.modes)

    @property
    def first_frequency(self) -> float | None:
        """Lowest frequency of the crankshaft itself [Hz]."""
        first = self.first_mode
        return None if first is None else float(self.modes.frequencies[first])

    def plot(self, axes: Axes | None = None, count: int = SHAPES_SHOWN) -> Axes:
        """Draw the first elastic mode shapes of the chain over its nodes.

        Raises
        ------
        InputError
            If the count is not 1 or more.
        """
        most = whole_number("count", count, 1, "a diagram shows some modes")
        modes, names = self.modes, [short_name(name) for name in self.chain.nodes]
        drawn = modes.drawn_shapes(range(modes.rigid, modes.rigid + most), names)
        axes = new_axes(axes)
        draw_chain_shapes(axes, drawn, MOTION[self.chain.kind].quantity)
        return axes


@result("speed", "order", "mode", "phase_sum", eq=True)
class WeightedCritical(Result):
    """A critical speed with the relative phase vector sum of the cylinders.

    Attributes
    ----------
    mode : int
        Elastic mode, from 1.
    speed : float
        Where the order meets the mode [rad/s].
    phase_sum : float
        Resultant of the cylinders' unit harmonics, weighted by the mode shape, relative to the largest
        possible one; 0 to 1.
    in_running_range : bool
        Whether the engine runs at that speed; limits may apply at higher speeds too.
    kind : {"major", "minor"}
        Of the order.
    """

    mode: int
    order: Number
    frequency: Hertz
    speed: Speed
    phase_sum: Number
    in_running_range: bool = True
    kind: Internal[str] = "major"

    @property
    def speed_rpm(self) -> float:
        """The speed [1/min]."""
        return self.speed * RPM

    @property
    def severity(self) -> float:
        """Size of the dot of a Campbell diagram."""
        return self.phase_sum

    @property
    def unbounded(self) -> bool:
        """Unknown without excitation and damping."""
        return False


@result("number", "frequency", eq=True)
class ChainMode(Result):
    """A natural mode of an engine's chain; elastic ones count from 1."""

    number: int
    frequency: Hertz
    rigid: bool
    crankshaft_share: Annotated[
        float, Quantity("1", "of the strain energy, in the crankshaft itself")
    ]
    of_crankshaft: bool
    node_positions: Annotated[tuple[float, ...], Quantity("1", "in elements from the first point")]
    shape: Annotated[tuple[float, ...], Quantity("1")]


@result("source", "first_frequency", eq=True)
class SourceFrequencies(Result):
    """The first frequencies of a chain with the compliances of one source."""

    source: str
    first_frequencies: Annotated[tuple[float, ...], Quantity("Hz")]
    first_mode: Annotated[
        int, Quantity("1", "the crankshaft's own, as chosen compliances number it")
    ]
    crankshaft_frequencies: Annotated[tuple[float, ...], Quantity("Hz")]
    first_frequency: Hertz
    beside_chosen: Annotated[float, Quantity("1", "ratio of the first frequencies")]
    mean_compliance: Annotated[float, Quantity(".compliance_unit")]
    remark: str


@result("kind", "frequencies [Hz]", "criticals", "unusable")
class Vibration(Result):
    """One kind of vibration (axial or torsional) of an engine.

    Attributes
    ----------
    chosen : SourceResult
        The source set in the engine file.
    others : tuple of SourceResult
        All sources, the chosen one included, for comparison.
    unusable : tuple of str
        Sources that gave no usable compliance, with the reason.
    criticals : tuple of WeightedCritical
        In the running range, and above it as far as a limit applies; ascending speed.
    started_through : tuple of WeightedCritical
        Those of modes of coupling, damper or line below the running range, which every start passes.
    """

    kind: Kind
    chosen: Internal[SourceResult]
    others: Internal[tuple[SourceResult, ...]]
    unusable: tuple[str, ...]
    criticals: tuple[WeightedCritical, ...]
    started_through: tuple[WeightedCritical, ...] = ()

    @cached_property
    def source(self) -> Part[str]:
        """Name of the chosen source."""
        return self.chosen.source

    @cached_property
    def nodes(self) -> Part[tuple[str, ...]]:
        """Names of the chain's points."""
        return tuple(self.chosen.chain.nodes)

    @cached_property
    def inertia(self) -> Annotated[Array, Quantity(".inertia_unit")]:
        """Of the points."""
        return self.chosen.chain.chain.inertia

    @cached_property
    def stiffness(self) -> Annotated[Array, Quantity(".stiffness_unit")]:
        """Of the elements."""
        return self.chosen.chain.chain.stiffness

    @cached_property
    def ground(self) -> Annotated[Array, Quantity(".stiffness_unit")]:
        """Stiffness of the points to ground."""
        return self.chosen.chain.chain.ground

    @cached_property
    def connections(self) -> Annotated[tuple[tuple[int, int], ...], Quantity("1")]:
        """Points at the ends of each element, from 0."""
        return tuple(self.chosen.chain.chain.connections)

    @cached_property
    def modes(self) -> Part[tuple[ChainMode, ...]]:
        """Natural modes with the chosen compliances."""
        modes = self.chosen.modes
        shares = self.chosen.chain.crankshaft_shares(modes).tolist()
        return tuple(
            ChainMode(
                number=mode + 1 - modes.rigid,
                frequency=frequency,
                rigid=mode < modes.rigid,
                crankshaft_share=shares[mode],
                of_crankshaft=shares[mode] >= CRANKSHAFT_MODE,
                node_positions=tuple(modes.node_positions[mode]),
                shape=tuple(modes.shapes[:, mode].tolist()),
            )
            for mode, frequency in enumerate(modes.frequencies.tolist())
        )

    @cached_property
    def sources(self) -> Part[tuple[SourceFrequencies, ...]]:
        """First frequencies with all sources."""
        chosen = self.chosen.modes
        # Another source changes this mode's frequency and name, but hardly its number.
        crankshaft = self.chosen.chain.first_mode(chosen)
        first = chosen.rigid if crankshaft is None else crankshaft
        return tuple(
            SourceFrequencies(
                source=other.source,
                first_frequencies=tuple(other.elastic_frequencies[:3].tolist()),
                first_mode=first - chosen.rigid + 1,
                crankshaft_frequencies=tuple(other.modes.frequencies[first : first + 3].tolist()),
                first_frequency=float(other.modes.frequencies[first]),
                beside_chosen=float(other.modes.frequencies[first] / chosen.frequencies[first]),
                mean_compliance=float(other.compliances.mean()),
                remark=other.remark,
            )
            for other in self.others
        )

    @property
    def frequencies(self) -> list[float]:
        """Elastic natural frequencies [Hz]."""
        return [mode.frequency for mode in self.elastic_modes]

    @property
    def elastic_modes(self) -> list[ChainMode]:
        """Modes without those of the rigid body."""
        return [mode for mode in self.modes if not mode.rigid]

    @property
    def first_mode(self) -> ChainMode | None:
        """The mode of the lowest frequency above zero, whatever of the system moves in it."""
        return next(iter(self.elastic_modes), None)

    @property
    def crankshaft_mode(self) -> ChainMode | None:
        """The crankshaft's first mode, which is not one of coupling, damper or line."""
        return next((mode for mode in self.elastic_modes if mode.of_crankshaft), None)

    @property
    def inertia_unit(self) -> str:
        """Of the points."""
        return MOTION[self.kind].inertia

    @property
    def stiffness_unit(self) -> str:
        """Of the elements."""
        return MOTION[self.kind].stiffness

    @property
    def compliance_unit(self) -> str:
        """Of a throw."""
        return MOTION[self.kind].compliance

    def plot(self, axes: Axes | None = None, *, count: int = SHAPES_SHOWN) -> Axes:
        """Draw the mode shapes of the chosen chain.

        Parameters
        ----------
        count : int, optional
            Number of mode shapes.

        Raises
        ------
        InputError
            If the count is not 1 or more.
        """
        axes = self.chosen.plot(axes, count)
        write_title(axes, f"{self.kind.capitalize()} modes")
        return axes

    def to_pandas(self) -> Any:
        """Return a table of the critical speeds in the running range, and above as far as a limit applies.

        Units are in ``frame.attrs["units"]``.
        """
        return table_of(self.criticals)

    @property
    def formula_note(self) -> str:
        """How a published formula was used, and where it does not apply; empty with other sources."""
        if self.source not in (*AXIAL_FORMULA_NAMES, *TORSIONAL_FORMULA_NAMES):
            return ""
        remark = next(other.remark for other in self.sources if other.source == self.source)
        return f"{self.kind} compliances by {self.source}: {remark}"

    def mode_table(self) -> Table:
        """Return the natural modes."""
        # Points have the numbers of their names: throws and main bearings count from 1.
        first = 0 if self.nodes[0].startswith(FREE_END) else 1

        def name(mode: ChainMode) -> str:
            beside = "" if mode.of_crankshaft else " (coupling, damper or line)"
            return "rigid body" if mode.rigid else f"{mode.number}{beside}"

        return Table.of_records(
            f"{self.kind.capitalize()} modes (compliances: {self.source})",
            self.modes,
            (Column("mode", words=True), name),
            (Column("frequency", "Hz", decimals=2), "frequency"),
            (Column("[1/min]", decimals=0), lambda mode: 60.0 * mode.frequency),
            (
                Column("nodes at", words=True),
                lambda mode: "moves as one" if mode.rigid else self._still_at(mode, first),
            ),
            note=f"Node positions count the chain's points: {_points(self.nodes, first)}.",
        )

    def _still_at(self, mode: ChainMode, first: int) -> str | None:
        """State the positions of a mode's nodes: by the numbers of the points, or on their branch."""
        positions_of_nodes = []
        for position in mode.node_positions:
            element = min(int(position), len(self.connections) - 1)
            (left, right), share = self.connections[element], position - element
            row = f"{first + left + share:.2f}"
            branch = f"{share:.2f} of the way from {self.nodes[left]} to {self.nodes[right]}"
            positions_of_nodes.append(row if right == left + 1 else branch)
        return ", ".join(positions_of_nodes) or None

    def critical_table(self) -> Table:
        """Return the critical speeds; those at which the cylinders act in phase are marked."""
        strongest = sorted(self.started_through, key=lambda critical: -critical.phase_sum)
        below = sorted(strongest[:STARTED_SHOWN], key=lambda critical: critical.speed)
        passed = ""
        if below:
            more = len(strongest) - len(below)
            passed = ", and of coupling, damper or line below it, which every start passes" + (
                f" ({more} of smaller phase sum are left out)" if more else ""
            )
        return Table.of_records(
            f"{self.kind.capitalize()} critical speeds in the running range{passed}, without damping",
            (*below, *self.criticals),
            (Column("speed", "1/min", decimals=1), "speed"),
            (Column("order", digits=None), "order"),
            (Column("mode"), "mode"),
            (Column("frequency", "Hz", decimals=2), "frequency"),
            (Column("phase sum", decimals=3), "phase_sum"),
            mark=lambda critical: (
                ("chosen" if critical.phase_sum >= TOGETHER else "")
                + ("" if critical.in_running_range else " below" if critical in below else " above")
            ),
        )

    def source_table(self, label: Callable[[str], str] = str) -> Table:
        """Return the first frequencies with every source, which `label` puts into words."""
        first = next((source.first_mode for source in self.sources), 1)
        # Modes of a coupling or a damper, below the crankshaft's own, hardly depend on its compliances.
        of_crankshaft = f" of the crankshaft, from mode {first} on," if first > 1 else ""
        return Table.of_records(
            f"First {self.kind} frequencies{of_crankshaft} by source of the compliances",
            self.sources,
            (Column("source", words=True), lambda source: label(source.source)),
            (Column("mean compliance", f"1e-9 {self.compliance_unit}"), "mean_compliance"),
            (Column("frequencies", "Hz", decimals=1), "crankshaft_frequencies"),
            (Column("ratio to chosen", decimals=3), "beside_chosen"),
            (Column("how it was used", words=True), "remark"),
            mark=lambda source: "chosen" if source.source == self.source else "",
        )


def _points(names: Sequence[str], first: int) -> str:
    """Name all points by their numbers; those whose own numbers ascend along the chain together.

    Examples
    --------
    >>> _points(["free end", "throw 1", "throw 2", "throw 3", "flywheel"], 0)
    '0 free end, 1 to 3 throw 1 to throw 3, 4 flywheel'
    """
    runs: list[list[int]] = []
    for place, name in enumerate(names):
        before = names[place - 1].rpartition(" ") if place else ("", "", "")
        stem, _, number = name.rpartition(" ")
        follows = before[2].isdecimal() and number.isdecimal() and int(number) == int(before[2]) + 1
        if follows and stem == before[0]:
            runs[-1].append(place)
        else:
            runs.append([place])
    return ", ".join(
        f"{first + run[0]} {names[run[0]]}"
        if len(run) == 1
        else f"{first + run[0]} to {first + run[-1]} {names[run[0]]} to {names[run[-1]]}"
        for run in runs
    )


def axial_vibration(
    engine_file: EngineFile,
    analysis: Analyses,
    shaft: "ShaftCompliances",
    model: "ComplianceModel | None",
    chosen_alone: bool = False,
) -> Vibration:
    """Calculate the axial natural frequencies and critical speeds of an engine.

    Parameters
    ----------
    chosen_alone : bool, optional
        Without other sources and critical speeds.

    Raises
    ------
    InputError
        If the source set in the engine file is unknown or unusable.
    """
    sources = axial_sources(engine_file, analysis, shaft, model)
    masses = [crank_analysis.mass for crank_analysis in crank_analyses(engine_file, analysis)]

    def chain(compliances: Array) -> EngineChain:
        return engine_axial_chain(engine_file, compliances, masses)

    forces = shaft.influence / shaft.axial[:, None]

    def weights(named: EngineChain, shape: Array) -> Array:
        return axial_weights(forces, shape[list(named.sections)])[list(engine_file.pins)]

    wanted = engine_file.vibration.axial_source
    return _vibration(engine_file, "axial", wanted, sources, chain, weights, chosen_alone)


def torsional_vibration(
    engine_file: EngineFile,
    analysis: Analyses,
    shaft: "ShaftCompliances",
    model: "ComplianceModel | None",
    chosen_alone: bool = False,
) -> Vibration:
    """Calculate the torsional natural frequencies and critical speeds; see `axial_vibration`."""
    sources = torsional_sources(engine_file, analysis, shaft, model)
    solids = [
        crank_analysis.masses.inertia_about_shaft
        for crank_analysis in crank_analyses(engine_file, analysis)
    ]
    inertias = engine_throw_inertias(engine_file, solids)

    def chain(compliances: Array) -> EngineChain:
        return engine_torsional_chain(engine_file, compliances, inertias)

    wanted = GIVEN if GIVEN in sources else engine_file.vibration.torsional_source

    def weights(named: EngineChain, shape: Array) -> Array:
        return shape[list(named.throw_nodes)][list(engine_file.throws)]

    return _vibration(engine_file, "torsional", wanted, sources, chain, weights, chosen_alone)


ChainMaker = Callable[[Array], EngineChain]
# Chain and mode shape to the work of a unit excitation of each cylinder.
Weights = Callable[[EngineChain, Array], Array]


def _vibration(
    engine_file: EngineFile,
    kind: Kind,
    wanted: str,
    sources: Sources,
    make_chain: ChainMaker,
    weights: Weights,
    chosen_alone: bool,
) -> Vibration:
    results, unusable = [], []
    for source, (compliances, remark) in sources.items():
        if chosen_alone and source.casefold() != wanted.casefold():
            continue
        if np.any(np.isnan(compliances)):
            unusable.append(f"{source}: {remark.rstrip('.')}")
            continue
        if not np.all(np.isfinite(compliances)) or np.min(compliances) <= 0.0:
            unusable.append(
                f"{source}: gives a compliance of {np.min(compliances):.3g}, not above zero"
            )
            continue
        chain = make_chain(compliances)
        results.append(SourceResult(source, compliances, chain, chain.chain.modes(), remark))
    chosen = next((r for r in results if r.source.casefold() == wanted.casefold()), None)
    if chosen is None:
        raise InputError(
            f"vibration.{kind}_source: given {wanted!r}; allowed are "
            f"{', '.join(r.source for r in results)}"
            + (f" (not usable here: {'; '.join(unusable)})." if unusable else ".")
        )
    if chosen_alone:
        return Vibration(kind, chosen, tuple(results), tuple(unusable), ())
    ends = assessment_end_speeds(engine_file)
    shares = chosen.chain.crankshaft_shares(chosen.modes)[chosen.modes.rigid :]
    return Vibration(
        kind,
        chosen,
        tuple(results),
        tuple(unusable),
        _criticals(engine_file, chosen, weights, (ends[0], ends[-1])),
        tuple(
            critical
            for critical in _criticals(engine_file, chosen, weights, (LEAST_SPEED, ends[0]))
            if shares[critical.mode - 1] < CRANKSHAFT_MODE and not at_most(ends[0], critical.speed)
        ),
    )


def _criticals(
    engine_file: EngineFile, result: SourceResult, weights: Weights, ends: tuple[float, float]
) -> tuple[WeightedCritical, ...]:
    engine = engine_file.engine
    orders = engine_orders(engine.strokes, engine_file.vibration.highest_order)
    criticals = critical_speeds(result.elastic_frequencies, orders, ends)
    shapes = result.modes.shapes[:, result.modes.rigid :]
    majors = major_orders(orders, engine.firing_angles)
    return tuple(
        WeightedCritical(
            critical.mode + 1,
            critical.order,
            critical.frequency,
            critical.speed,
            _phase_sum(
                weights(result.chain, shapes[:, critical.mode]),
                critical.order,
                engine.firing_angles,
            ),
            bool(within(critical.speed, engine.lowest_speed, engine.highest_speed)),
            "major" if np.any(np.isclose(critical.order, majors)) else "minor",
        )
        for critical in criticals
    )


def axial_weights(forces: Array, shape: Array) -> Array:
    """Work of a unit radial force on each pin on an axial mode shape.

    Parameters
    ----------
    forces : (n, pins) array
        Axial force P in throw i per radial force on pin j, at constant length of the throws.
    shape : (n + 1,) array
        Displacements of the main-journal middles.
    """
    return forces.T @ np.diff(shape)


def _phase_sum(weights: Array, order: float, firing: Sequence[float]) -> float:
    largest = float(np.abs(weights).sum())
    if math.isclose(largest, 0.0):
        return 0.0
    return float(vector_sums([order], firing, weights)[0]) / largest
