"""Axial and torsional vibration of an engine, with the compliances of any source."""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from crankbase.choices import whole_number
from crankbase.diagrams import new_axes, write_title
from crankbase.errors import InputError
from crankbase.frames import table
from crankbase.summaries import summarized
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
from dynamics.chains.engine_chains import EngineChain
from dynamics.critical import (
    CriticalSpeed,
    critical_speeds,
    engine_orders,
    major_orders,
    vector_sums,
)
from dynamics.plots.mode_shapes import draw_chain_shapes, shape_labels
from fem.superelement import ShaftCompliances
from regression.models.compliance_model import ComplianceModel

if TYPE_CHECKING:
    from matplotlib.axes import Axes

SHAPES_SHOWN = 3


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
    compliances: NDArray[np.float64]
    chain: EngineChain
    modes: Modes
    remark: str

    @property
    def elastic_frequencies(self) -> NDArray[np.float64]:
        """Natural frequencies without rigid-body modes [Hz]."""
        return self.modes.elastic_frequencies

    @property
    def first_frequency(self) -> float | None:
        """Lowest frequency of the crankshaft itself [Hz]; see `EngineChain.first_mode`."""
        first = self.chain.first_mode(self.modes)
        return None if first is None else float(self.modes.frequencies[first])

    def plot(self, axes: "Axes | None" = None, count: int = SHAPES_SHOWN) -> "Axes":
        """Draw the first elastic mode shapes of the chain over its nodes.

        Raises
        ------
        InputError
            If the count is not 1 or more.
        """
        most = whole_number("count", count, 1, "a diagram shows some modes")
        modes = self.modes
        shown = slice(modes.rigid, min(modes.rigid + most, len(modes.frequencies)))
        positions = modes.node_positions[shown]
        axes = new_axes(axes)
        draw_chain_shapes(
            axes,
            modes.shapes[:, shown],
            shape_labels(modes.frequencies[shown], positions),
            positions,
            self.chain.chain.connections,
            [short_name(name) for name in self.chain.nodes],
            MOTION[self.chain.kind].quantity,
        )
        return axes


@dataclass(frozen=True)
class WeightedCritical:
    """A critical speed with the relative phase vector sum of the cylinders.

    Attributes
    ----------
    phase_sum : float
        Resultant of the cylinders' unit harmonics, weighted by the mode shape, relative to the largest
        possible one; 0 to 1.
    in_running_range : bool
        Whether the engine runs at that speed; limits may apply at higher speeds too.
    kind : {"major", "minor"}
        Of the order.
    """

    critical: CriticalSpeed
    phase_sum: float
    in_running_range: bool = True
    kind: str = "major"

    @property
    def frequency(self) -> float:
        """Of the mode [Hz]."""
        return self.critical.frequency

    @property
    def speed_rpm(self) -> float:
        """Where the order meets the mode [1/min]."""
        return self.critical.speed_rpm

    @property
    def severity(self) -> float:
        """Size of the dot of a Campbell diagram."""
        return self.phase_sum

    @property
    def unbounded(self) -> bool:
        """Unknown without excitation and damping."""
        return False


@summarized("kind", "chosen.elastic_frequencies [Hz]", "criticals", "unusable")
@dataclass(frozen=True)
class Vibration:
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
    """

    kind: str
    chosen: SourceResult
    others: tuple[SourceResult, ...]
    unusable: tuple[str, ...]
    criticals: tuple[WeightedCritical, ...]

    def plot(self, axes: "Axes | None" = None, *, count: int = SHAPES_SHOWN) -> "Axes":
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
        criticals = [critical.critical for critical in self.criticals]
        return table(
            {
                "mode": ([critical.mode + 1 for critical in criticals], "1"),
                "order": ([critical.order for critical in criticals], "1"),
                "frequency": ([critical.frequency for critical in criticals], "Hz"),
                "speed": ([critical.speed for critical in criticals], "rad/s"),
                "phase_sum": ([critical.phase_sum for critical in self.criticals], "1"),
                "in_running_range": (
                    [critical.in_running_range for critical in self.criticals],
                    "",
                ),
            }
        )


def axial_vibration(
    engine_file: EngineFile,
    analysis: Analyses,
    shaft: ShaftCompliances,
    model: ComplianceModel | None,
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

    def chain(compliances: NDArray[np.float64]) -> EngineChain:
        return engine_axial_chain(engine_file, compliances, masses)

    forces = shaft.influence / shaft.axial[:, None]

    def weights(named: EngineChain, shape: NDArray[np.float64]) -> NDArray[np.float64]:
        return axial_weights(forces, shape[list(named.sections)])[list(engine_file.pins)]

    wanted = engine_file.vibration.axial_source
    return _vibration(engine_file, "axial", wanted, sources, chain, weights, chosen_alone)


def torsional_vibration(
    engine_file: EngineFile,
    analysis: Analyses,
    shaft: ShaftCompliances,
    model: ComplianceModel | None,
    chosen_alone: bool = False,
) -> Vibration:
    """Calculate the torsional natural frequencies and critical speeds; see `axial_vibration`."""
    sources = torsional_sources(engine_file, analysis, shaft, model)
    solids = [
        crank_analysis.masses.inertia_about_shaft
        for crank_analysis in crank_analyses(engine_file, analysis)
    ]
    inertias = engine_throw_inertias(engine_file, solids)

    def chain(compliances: NDArray[np.float64]) -> EngineChain:
        return engine_torsional_chain(engine_file, compliances, inertias)

    wanted = GIVEN if GIVEN in sources else engine_file.vibration.torsional_source

    def weights(named: EngineChain, shape: NDArray[np.float64]) -> NDArray[np.float64]:
        return shape[list(named.throw_nodes)][list(engine_file.throws)]

    return _vibration(engine_file, "torsional", wanted, sources, chain, weights, chosen_alone)


ChainMaker = Callable[[NDArray[np.float64]], EngineChain]
# Chain and mode shape to the work of a unit excitation of each cylinder.
Weights = Callable[[EngineChain, NDArray[np.float64]], NDArray[np.float64]]


def _vibration(
    engine_file: EngineFile,
    kind: str,
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
    criticals = () if chosen_alone else _criticals(engine_file, chosen, weights)
    return Vibration(kind, chosen, tuple(results), tuple(unusable), criticals)


def _criticals(
    engine_file: EngineFile, result: SourceResult, weights: Weights
) -> tuple[WeightedCritical, ...]:
    engine = engine_file.engine
    orders = engine_orders(engine.strokes, engine_file.vibration.highest_order)
    ends = assessment_end_speeds(engine_file)
    criticals = critical_speeds(result.elastic_frequencies, orders, (ends[0], ends[-1]))
    shapes = result.modes.shapes[:, result.modes.rigid :]
    majors = major_orders(orders, engine.firing_angles)
    return tuple(
        WeightedCritical(
            critical,
            _phase_sum(
                weights(result.chain, shapes[:, critical.mode]),
                critical.order,
                engine.firing_angles,
            ),
            critical.speed <= engine.highest_speed,
            "major" if np.any(np.isclose(critical.order, majors)) else "minor",
        )
        for critical in criticals
    )


def axial_weights(forces: NDArray[np.float64], shape: NDArray[np.float64]) -> NDArray[np.float64]:
    """Work of a unit radial force on each pin on an axial mode shape.

    Parameters
    ----------
    forces : (n, pins) array
        Axial force P in throw i per radial force on pin j, at constant length of the throws.
    shape : (n + 1,) array
        Displacements of the main-journal middles.
    """
    return forces.T @ np.diff(shape)


def _phase_sum(weights: NDArray[np.float64], order: float, firing: Sequence[float]) -> float:
    largest = float(np.abs(weights).sum())
    if math.isclose(largest, 0.0):
        return 0.0
    return float(vector_sums([order], firing, weights)[0]) / largest
