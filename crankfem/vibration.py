"""Axial and torsional vibration of an engine, with the compliances of any source."""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from crankfem.engine_file import EngineFile
from dynamics.chain import Modes
from dynamics.critical import CriticalSpeed, critical_speeds, engine_orders, vector_sums
from dynamics.engine_chains import NamedChain, axial_chain, throw_inertia, torsional_chain
from fem.analysis import ThrowAnalysis
from fem.shaft import ShaftCompliances, shaft_compliances
from geometry.errors import InputError
from regression.formulas.axial_formulas import axial_formulas, fold_angle_deg
from regression.formulas.torsional_formulas import torsional_formulas
from regression.models.compliance_model import ComplianceModel

FE, FE_PINNED, REGRESSION = "fe", "fe pinned", "regression"
# The formulas know no free end: a throw tilts there as it does beside an opposite crank.
NO_NEIGHBOR_DEG = 180.0


@dataclass(frozen=True)
class SourceResult:
    """A chain with the compliances of one source, and its modes.

    Attributes
    ----------
    source : str
        "fe", "fe pinned", "regression" or a formula's name.
    compliances : (n,) array
        Of each throw [m/N or rad/(N m)].
    chain : NamedChain
    modes : Modes
    remark : str
        How the source was used.
    """

    source: str
    compliances: NDArray[np.float64]
    chain: NamedChain
    modes: Modes
    remark: str

    @property
    def elastic_frequencies(self) -> NDArray[np.float64]:
        """Natural frequencies without rigid-body modes [Hz]."""
        return self.modes.frequencies[self.modes.rigid :]


@dataclass(frozen=True)
class WeightedCritical:
    """A critical speed with the share of the cylinders' excitation that reaches the mode.

    Attributes
    ----------
    critical : CriticalSpeed
    phase_sum : float
        Resultant of the cylinders' unit harmonics, weighted by the mode shape, beside the largest
        possible one; 0 to 1.
    """

    critical: CriticalSpeed
    phase_sum: float


@dataclass(frozen=True)
class Vibration:
    """One kind of vibration (axial or torsional) of an engine.

    Attributes
    ----------
    kind : str
    chosen : SourceResult
        The source set in the engine file.
    others : tuple of SourceResult
        All sources, the chosen one included, for comparison.
    unusable : tuple of str
        Sources that gave no usable compliance, with the reason.
    criticals : tuple of WeightedCritical
        In the running range, ascending speed.
    """

    kind: str
    chosen: SourceResult
    others: tuple[SourceResult, ...]
    unusable: tuple[str, ...]
    criticals: tuple[WeightedCritical, ...]


def throw_rotational_inertia(engine_file: EngineFile, analysis: ThrowAnalysis) -> float:
    """Inertia of one throw with its share of rod and piston [kg m^2]."""
    rod = engine_file.rod
    return throw_inertia(
        analysis.masses.inertia_about_shaft,
        rod.rotating_mass,
        engine_file.piston.mass + rod.mass - rod.rotating_mass,
        engine_file.throw.crank_radius,
    )


def compliances_in_shaft(engine_file: EngineFile, analysis: ThrowAnalysis) -> ShaftCompliances:
    """FE compliances of each throw at its place among the engine's cranks."""
    throws = [analysis.superelement] * engine_file.engine.cylinders
    return shaft_compliances(throws, engine_file.engine.crank_angles)


def axial_vibration(
    engine_file: EngineFile,
    analysis: ThrowAnalysis,
    shaft: ShaftCompliances,
    model: ComplianceModel | None,
) -> Vibration:
    """Calculate the axial natural frequencies and critical speeds of an engine.

    Parameters
    ----------
    engine_file : EngineFile
    analysis : ThrowAnalysis
        Of the engine's throw.
    shaft : ShaftCompliances
        From `compliances_in_shaft`.
    model : ComplianceModel or None
        The regression, if there is one.

    Raises
    ------
    InputError
        If the source set in the engine file is unknown or unusable.
    """
    pinned = analysis.axial_compliance("pinned")
    sources = _fe_sources(shaft.axial, pinned)
    if model is not None:
        value = model.of_throw(engine_file.throw)["axial_compliance"].value
        sources[REGRESSION] = _from_regression(shaft.axial, value, pinned)
    sources |= _axial_formula_sources(engine_file)
    thrust = engine_file.thrust_bearing
    count = engine_file.engine.cylinders

    def chain(compliances: NDArray[np.float64]) -> NamedChain:
        return axial_chain(
            compliances,
            np.full(count, analysis.mass),
            engine_file.flywheel.mass,
            thrust.bearing,
            thrust.stiffness,
        )

    forces = shaft.influence / shaft.axial[:, None]

    def weights(_: NamedChain, shape: NDArray[np.float64]) -> NDArray[np.float64]:
        return axial_weights(forces, shape)

    wanted = engine_file.vibration.axial_source
    return _vibration(engine_file, "axial", wanted, sources, chain, weights)


def torsional_vibration(
    engine_file: EngineFile,
    analysis: ThrowAnalysis,
    shaft: ShaftCompliances,
    model: ComplianceModel | None,
) -> Vibration:
    """Calculate the torsional natural frequencies and critical speeds; see `axial_vibration`."""
    pinned = analysis.torsional_compliance("pinned")
    sources = _fe_sources(shaft.torsional, pinned)
    if model is not None:
        value = model.of_throw(engine_file.throw)["torsional_compliance"].value
        sources[REGRESSION] = _from_regression(shaft.torsional, value, pinned)
    material = engine_file.material
    count = engine_file.engine.cylinders
    for name, formula in torsional_formulas(
        engine_file.throw,
        youngs_modulus=material.youngs_modulus,
        poisson_ratio=material.poisson_ratio,
    ).items():
        sources[name] = (np.full(count, formula.value), "the same for every throw")
    inertia = throw_rotational_inertia(engine_file, analysis)

    def chain(compliances: NDArray[np.float64]) -> NamedChain:
        return torsional_chain(
            compliances,
            np.full(count, inertia),
            engine_file.flywheel.inertia,
            0.0 if engine_file.free_end is None else engine_file.free_end.inertia,
        )

    wanted = engine_file.vibration.torsional_source
    return _vibration(engine_file, "torsional", wanted, sources, chain, torsional_weights)


Sources = dict[str, tuple[NDArray[np.float64], str]]
ChainMaker = Callable[[NDArray[np.float64]], NamedChain]
# Chain and mode shape to the work of a unit excitation at each cylinder.
Weights = Callable[[NamedChain, NDArray[np.float64]], NDArray[np.float64]]


def _fe_sources(in_shaft: NDArray[np.float64], pinned: float) -> Sources:
    return {
        FE: (in_shaft, "superelements assembled at the crank angles"),
        FE_PINNED: (
            np.full_like(in_shaft, pinned),
            "a single throw with ends free to tilt; too soft beside neighbors that hinder the tilt",
        ),
    }


def _from_regression(
    in_shaft: NDArray[np.float64], value: float, pinned: float
) -> tuple[NDArray[np.float64], str]:
    return (
        value * in_shaft / pinned,
        "the equation's pinned value, times each throw's ratio from the assembled superelements",
    )


def _axial_formula_sources(engine_file: EngineFile) -> Sources:
    """Formula values of each throw: the mean of those at the angles to either neighbor."""
    angles = np.rad2deg(engine_file.engine.crank_angles)
    gaps = [NO_NEIGHBOR_DEG, *np.abs(np.diff(angles)).tolist(), NO_NEIGHBOR_DEG]
    material = engine_file.material
    tables = [
        axial_formulas(
            engine_file.throw,
            gap,
            youngs_modulus=material.youngs_modulus,
            poisson_ratio=material.poisson_ratio,
        )
        for gap in gaps
    ]
    sources: Sources = {}
    for name in tables[0]:
        values = np.array([table[name].value for table in tables])
        wrong = {
            round(fold_angle_deg(gap))
            for gap, table in zip(gaps, tables, strict=True)
            if not table[name].valid
        }
        remark = "mean of the formula at the angles to both neighbors; 180 deg at the shaft's ends"
        if wrong:
            remark += f"; does not apply at {', '.join(str(angle) for angle in sorted(wrong))} deg"
        sources[name] = (0.5 * (values[:-1] + values[1:]), remark)
    return sources


def _vibration(
    engine_file: EngineFile,
    kind: str,
    wanted: str,
    sources: Sources,
    make_chain: ChainMaker,
    weights: Weights,
) -> Vibration:
    results, unusable = [], []
    for source, (compliances, remark) in sources.items():
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
    return Vibration(
        kind, chosen, tuple(results), tuple(unusable), _criticals(engine_file, chosen, weights)
    )


def _criticals(
    engine_file: EngineFile, result: SourceResult, weights: Weights
) -> tuple[WeightedCritical, ...]:
    engine = engine_file.engine
    orders = engine_orders(engine.strokes, engine_file.vibration.highest_order)
    found = critical_speeds(
        result.elastic_frequencies, orders, (engine.lowest_speed, engine.highest_speed)
    )
    shapes = result.modes.shapes[:, result.modes.rigid :]
    return tuple(
        WeightedCritical(
            critical,
            _phase_sum(
                weights(result.chain, shapes[:, critical.mode]),
                critical.order,
                engine.firing_angles,
            ),
        )
        for critical in found
    )


def axial_weights(forces: NDArray[np.float64], shape: NDArray[np.float64]) -> NDArray[np.float64]:
    """Work of a unit radial force at each cylinder on an axial mode shape.

    Parameters
    ----------
    forces : (n, n) array
        Axial force P in throw i per radial force on pin j, the throws' lengths kept.
    shape : (n + 1,) array
        Displacements of the main-journal middles.
    """
    return forces.T @ np.diff(shape)


def torsional_weights(chain: NamedChain, shape: NDArray[np.float64]) -> NDArray[np.float64]:
    """Work of a unit torque at each cylinder on a torsional mode shape: its twist there."""
    return np.array(
        [v for node, v in zip(chain.nodes, shape, strict=True) if node.startswith("cylinder")]
    )


def _phase_sum(weights: NDArray[np.float64], order: float, firing: Sequence[float]) -> float:
    largest = float(np.abs(weights).sum())
    if math.isclose(largest, 0.0):
        return 0.0
    return float(vector_sums([order], firing, weights)[0]) / largest
