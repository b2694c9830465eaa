"""Forced vibration of an engine's chains over its speeds, under the forces of its cylinders."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from crankfem.engine_file import EngineFile
from crankfem.excitation_input import (
    gas_map_load,
    gas_map_pressure,
    misfire_shares,
    motored_for_misfire,
)
from crankfem.mechanism_file import MechanismFile
from crankfem.vibration.chains import damped_engine_chain
from crankfem.vibration.modes import SourceResult, Vibration
from dynamics.chains.engine_chains import EngineChain
from dynamics.critical import engine_orders
from dynamics.excitation.axial_comparison import AxialForceComparison, compare_axial_forces
from dynamics.excitation.combined import combined_excitation
from dynamics.excitation.cylinder_harmonics import CylinderHarmonics, cylinder_harmonics
from dynamics.excitation.cylinders import CylinderForces, forces_at_speeds
from dynamics.excitation.on_chains import axial_excitation, torque_excitation
from dynamics.excitation.pressure_map import PressureMap
from dynamics.excitation.propeller import propeller_excitation
from dynamics.excitation.torsion_to_axial import axial_excitation_of_torsion, torsion_influence
from dynamics.gas.pressure import GasPressure
from dynamics.response.damping import DampedChain
from dynamics.response.excitation import OrderExcitation
from dynamics.response.forced import ForcedResponse, forced_response
from dynamics.response.linear_system import DEFAULT_MAGNIFIER
from dynamics.response.loads import ElementLoads, alternating_stress, element_loads, section_modulus
from dynamics.response.power import PowerBalance, power_balance
from dynamics.response.resonance import Resonance, resonances
from dynamics.response.series import OrderSeries
from dynamics.response.speed_grid import refined_speeds
from fem.analysis import ThrowAnalysis
from fem.shaft import ShaftCompliances
from geometry.errors import InputError
from geometry.throw import CrankThrow

# Speeds below the lowest running one are passed on every start; rules of limits go on above the highest
# running speed and the rated one.
BELOW, ABOVE_HIGHEST, ABOVE_RATED = 0.5, 1.05, 1.15
# Of the even grid; resonances get further speeds.
POINTS = 150

Frequencies = Sequence[float] | NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class ForcedVibration:
    """One kind of forced vibration (axial or torsional) of an engine.

    Attributes
    ----------
    kind : str
    engine_chain : EngineChain
    damping : tuple of str
        What damps, one sentence each, with its source.
    remarks : tuple of str
        What was left out, a sentence each.
    forces : CylinderForces
        Of the cylinders on their pins.
    response : ForcedResponse
    loads : ElementLoads
        Torque [N m] or force [N] in each element.
    stress : OrderSeries or None
        Nominal torsional stress of the crankshaft's elements [Pa]; None in the axial direction.
    power : PowerBalance
    resonances : tuple of Resonance
        Within the running range, with the amplitude of the free end, ascending speed.
    axial_forces : AxialForceComparison or None
        Exciting force of each throw by its own coefficient and by the assembled shaft.
    """

    kind: str
    engine_chain: EngineChain
    damping: tuple[str, ...]
    remarks: tuple[str, ...]
    forces: CylinderForces
    response: ForcedResponse
    loads: ElementLoads
    stress: OrderSeries | None
    power: PowerBalance
    resonances: tuple[Resonance, ...]
    axial_forces: AxialForceComparison | None

    @property
    def free_end(self) -> OrderSeries:
        """Motion of the free end [rad or m], without that of the rigid body, one place."""
        series = self.response.elastic
        return OrderSeries(
            series.orders,
            series.speeds,
            series.values[:, :, :1],
            series.unbounded,
            series.names[:1],
        )

    @property
    def crank_elements(self) -> OrderSeries:
        """Torque or force in the elements of the crankshaft itself, from the free end."""
        elements = self.loads.elements
        return OrderSeries(
            elements.orders,
            elements.speeds,
            elements.values[:, :, : _crank_elements(self.engine_chain)],
            elements.unbounded,
            elements.names[: _crank_elements(self.engine_chain)],
        )


def engine_harmonics(engine_file: EngineFile, mechanism: MechanismFile) -> CylinderHarmonics:
    """Harmonics of the pin forces of an engine's cylinders, up to the file's highest order.

    Parameters
    ----------
    engine_file : EngineFile
        Its pressure map, if it has one, is used in place of the one diagram of [gas].
    mechanism : MechanismFile
        With gas pressure.

    Raises
    ------
    InputError
        If a pressure cannot be read, or its samples do not resolve the highest order.
    """
    pressure: PressureMap | tuple[GasPressure, ...] = mechanism.pressure
    if engine_file.gas_map is not None:
        pressure = gas_map_pressure(
            engine_file.gas_map, engine_file.engine.strokes, engine_file.path
        )
    misfire, motored = misfire_shares(engine_file.misfire), None
    if misfire and engine_file.gas is not None:
        motored = motored_for_misfire(engine_file.gas, mechanism.layout, mechanism.pressure)
    return cylinder_harmonics(
        mechanism.layout,
        engine_orders(engine_file.engine.strokes, engine_file.vibration.highest_order),
        pressure,
        misfire=misfire,
        motored=motored,
        throws=mechanism.throws,
    )


def forced_vibrations(
    engine_file: EngineFile,
    harmonics: CylinderHarmonics,
    axial: Vibration,
    torsional: Vibration,
    shaft: ShaftCompliances,
    analysis: ThrowAnalysis,
    further: Frequencies = (),
) -> tuple[ForcedVibration, ForcedVibration]:
    """Calculate the forced vibration of an engine's chains over its speeds.

    Parameters
    ----------
    engine_file : EngineFile
    harmonics : CylinderHarmonics
        From `engine_harmonics`.
    axial, torsional : Vibration
        Modes of the chains with the chosen compliances.
    shaft : ShaftCompliances
        Of the throws in the shaft.
    analysis : ThrowAnalysis
    further : (m,) array, optional
        Natural frequencies of what else is to be calculated at the same speeds [Hz].

    Returns
    -------
    axial, torsional : ForcedVibration
        On one grid of speeds, from half the lowest running speed to 5 % above the highest (and 15 % above
        the rated one). Axial
        vibration is excited by the radial forces and by the torques of the torsional vibration.
    """
    chains = [damped_engine_chain(engine_file, own.chosen.chain) for own in (axial, torsional)]
    forces = _forces(engine_file, harmonics, chains, further)
    cranks = torsional.chosen.chain
    twisted = forced_response(
        chains[1], _with_propeller(engine_file, cranks, torque_excitation(forces, cranks))
    )
    pressed, remarks = _axial_excitation(engine_file, forces, axial.chosen, shaft, cranks, twisted)
    lengthened = forced_response(
        chains[0], _with_propeller(engine_file, axial.chosen.chain, pressed)
    )
    loads = element_loads(twisted)
    running = (engine_file.engine.lowest_speed, engine_file.engine.highest_speed)
    return (
        ForcedVibration(
            kind="axial",
            engine_chain=axial.chosen.chain,
            damping=chains[0].record,
            remarks=remarks,
            forces=forces,
            response=lengthened,
            loads=element_loads(lengthened),
            stress=None,
            power=power_balance(lengthened),
            resonances=resonances(lengthened, 0, speed_range=running),
            axial_forces=_two_ways(
                forces, axial.chosen.compliances, shaft, analysis, engine_file.pins
            ),
        ),
        ForcedVibration(
            kind="torsional",
            engine_chain=cranks,
            damping=chains[1].record,
            remarks=(),
            forces=forces,
            response=twisted,
            loads=loads,
            stress=alternating_stress(loads, _sections(engine_file.throw, cranks)),
            power=power_balance(twisted),
            resonances=resonances(twisted, 0, speed_range=running),
            axial_forces=None,
        ),
    )


def _forces(
    engine_file: EngineFile,
    harmonics: CylinderHarmonics,
    chains: Sequence[DampedChain],
    further: Frequencies,
) -> CylinderForces:
    """Forces of the cylinders at speeds among which no resonance is missed."""
    ratios = [np.maximum(own.system.damping_ratios(), 1e-4) for own in chains]
    speeds = refined_speeds(
        np.concatenate([*(own.system.elastic_frequencies for own in chains), further]),
        np.concatenate([*ratios, np.full(len(further), 0.5 / DEFAULT_MAGNIFIER)]),
        harmonics.orders,
        _speed_range(engine_file),
        points=POINTS,
    )
    load = None
    if engine_file.gas_map is not None:
        load = gas_map_load(engine_file.gas_map, engine_file.engine.rated_speed)
    return forces_at_speeds(harmonics, speeds, load)


def _axial_excitation(
    engine_file: EngineFile,
    forces: CylinderForces,
    axial: SourceResult,
    shaft: ShaftCompliances,
    cranks: EngineChain,
    twisted: ForcedResponse,
) -> tuple[OrderExcitation, tuple[str, ...]]:
    """Axial force of each throw by radial forces and torques in the shaft, and what is left out.

    Whatever the source of the chain's compliances, the exciting forces are those of the finite
    elements: lengthening over compliance, both of the assembled shaft.
    """
    scale = (axial.compliances / shaft.axial)[:, None]
    by_radial = axial_excitation(
        forces, axial.chain, axial.compliances, scale * shaft.influence, engine_file.pins
    )
    if shaft.tangential.shape[1] != len(shaft.axial):
        return by_radial, (
            "the axial force that torque in the shaft excites is left out, because throws have several "
            "pins",
        )
    if np.any(twisted.unbounded):
        return by_radial, (
            "the axial force that torque in the shaft excites is left out, because torsional vibration "
            "is unbounded",
        )
    # The finite elements count angles as the file does, torques here are positive as the shaft turns.
    sense = engine_file.engine.turning_sense
    influence = torsion_influence(
        sense * shaft.tangential, sense * shaft.through, engine_file.throw.crank_radius
    )
    by_torque = axial_excitation_of_torsion(
        twisted, cranks, axial.chain, axial.compliances, scale * influence
    )
    return combined_excitation(by_radial, by_torque), ()


def nominal_section_modulus(throw: CrankThrow) -> float:
    """Section modulus of the weaker of main journal and crankpin in torsion [m^3]."""
    moduli = section_modulus(
        "torsional",
        [throw.main_journal_diameter, throw.pin_diameter],
        [throw.main_journal_bore, throw.pin_bore],
    )
    return float(np.min(moduli))


def _speed_range(engine_file: EngineFile) -> tuple[float, float]:
    """From half the lowest running speed to above the highest one, within the pressure map."""
    engine = engine_file.engine
    low = BELOW * engine.lowest_speed
    high = max(ABOVE_HIGHEST * engine.highest_speed, ABOVE_RATED * engine.rated_speed)
    if engine_file.gas_map is not None:
        taken = [point.speed for point in engine_file.gas_map.points]
        low = min(max(low, min(taken)), engine.lowest_speed)
        high = max(min(high, max(taken)), engine.highest_speed)
    return low, high


def _with_propeller(
    engine_file: EngineFile, chain: EngineChain, excitation: OrderExcitation
) -> OrderExcitation:
    """Add what a propeller excites, where the file gives its harmonics for this kind.

    Raises
    ------
    InputError
        If the chain has no such node.
    """
    given = engine_file.propeller_forces
    if given is None:
        return excitation
    if not (given.torque_shares if chain.kind == "torsional" else given.thrust_shares):
        return excitation
    if given.node not in chain.nodes:
        raise InputError(
            f"propeller_forces.node: given {given.node!r}; allowed are {', '.join(chain.nodes)}, because "
            f"these are the nodes of the {chain.kind} chain (a shaft line brings the propeller's)."
        )
    acting = propeller_excitation(
        given.forces,
        chain.chain,
        chain.nodes.index(given.node),
        excitation.speeds,
        kind=chain.kind,
        ratio=given.ratio,
    )
    return combined_excitation(excitation, acting)


def _two_ways(
    forces: CylinderForces,
    compliances: NDArray[np.float64],
    shaft: ShaftCompliances,
    analysis: ThrowAnalysis,
    pins: Sequence[int],
) -> AxialForceComparison:
    """Force c Z / e_n of each throw by itself, beside that in the assembled shaft."""
    ratio = analysis.influence_coefficient("pinned") / analysis.axial_compliance("pinned")
    influence = shaft.influence / shaft.axial[:, None] * compliances[:, None]
    return compare_axial_forces(forces, compliances, ratio * compliances, influence, pins=pins)


def _crank_elements(chain: EngineChain) -> int:
    """Number of elements between free end (or first throw) and flywheel, the first of the chain."""
    if chain.kind == "axial":
        return chain.throws
    return chain.throw_nodes[-1] + 1


def _sections(throw: CrankThrow, chain: EngineChain) -> dict[int, float]:
    return dict.fromkeys(range(_crank_elements(chain)), nominal_section_modulus(throw))
