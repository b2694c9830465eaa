"""The damped chains of an engine, and their answers to the forces of its cylinders."""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from crankbase.array_checks import Array
from crankbase.results import Internal
from crankfem.analyses.shaft.chains import damped_engine_chain
from crankfem.analyses.vibration.engine_excitation import (
    excitation_along_shaft,
    forces_over_speeds,
    with_propeller,
)
from crankfem.analyses.vibration.modes import SourceResult, Vibration
from crankfem.files.engine.engine_file import EngineFile
from dynamics.chains.engine_chains import EngineChain
from dynamics.excitation.chain_excitation import torque_excitation
from dynamics.excitation.cylinders import CylinderForces, CylinderHarmonics
from dynamics.response.complex_modes import ComplexModes, complex_modes
from dynamics.response.forced import ForcedResponse, forced_response
from dynamics.response.linear_system import DampedChain
from dynamics.response.loads import ElementLoads, alternating_stress, element_loads, section_modulus
from dynamics.response.order_excitation import OrderExcitation
from dynamics.response.peak_cause import PeakCause, peak_cause
from dynamics.response.series import OrderSeries
from fem.superelement import ShaftCompliances
from geometry.any_throw import Throw


@dataclass(frozen=True, eq=False)
class ChainAnswer:
    """Motion of one chain, and quantities with limits, calculated on demand.

    Attributes
    ----------
    moduli : dict of int to float
        Section modulus of each element of the crankshaft [m^3]; none in the axial direction.
    by_torque : OrderExcitation or None
        Of axial vibration, the part of its excitation due to torques in the shaft.
    remarks : tuple of str
        Parts left out of the excitation.
    """

    engine_chain: Internal[EngineChain]
    response: Internal[ForcedResponse]
    moduli: Internal[dict[int, float]]
    by_torque: Internal[OrderExcitation | None] = None
    remarks: Internal[tuple[str, ...]] = ()

    @cached_property
    def modes(self) -> ComplexModes:
        """The damped modes of the chain."""
        return complex_modes(self.response)

    @cached_property
    def loads(self) -> ElementLoads:
        """Torque [N m] or force [N] in each element."""
        return element_loads(self.response)

    @cached_property
    def stress(self) -> OrderSeries | None:
        """Nominal torsional stress of the crankshaft's elements [Pa]; None in the axial direction."""
        return alternating_stress(self.loads, self.moduli) if self.moduli else None

    @cached_property
    def free_end(self) -> OrderSeries:
        """Motion of the free end [rad or m], relative to that of the rigid body, one location."""
        return first_places(self.response.elastic, 1)

    @cached_property
    def crank_elements(self) -> OrderSeries:
        """Torque or force in the elements of the crankshaft itself, from the free end."""
        return first_places(self.loads.elements, self.engine_chain.crank_elements)


# Of the axial and of the torsional chain.
Answers = tuple[ChainAnswer, ChainAnswer]


@dataclass(frozen=True, eq=False)
class EngineChains:
    """The damped chains of an engine, ready for forces.

    Attributes
    ----------
    pulled : SourceResult
        The axial chain and its compliances.
    cranks : EngineChain
        The torsional chain.
    damped : tuple of two DampedChain
        The axial one and the torsional one.
    """

    engine_file: EngineFile
    pulled: SourceResult
    cranks: EngineChain
    damped: tuple[DampedChain, DampedChain]
    shaft: ShaftCompliances

    @classmethod
    def of(
        cls,
        engine_file: EngineFile,
        axial: Vibration,
        torsional: Vibration,
        shaft: ShaftCompliances,
    ) -> "EngineChains":
        """Damp the chains with the chosen compliances."""
        pulled, cranks = axial.chosen, torsional.chosen.chain
        damped = (
            damped_engine_chain(engine_file, pulled.chain),
            damped_engine_chain(engine_file, cranks),
        )
        return cls(engine_file, pulled, cranks, damped, shaft)

    @cached_property
    def moduli(self) -> dict[int, float]:
        """Section modulus of each element of the crankshaft in torsion, that of the weaker throw [m^3]."""
        cranks = self.cranks
        moduli = [nominal_section_modulus(throw) for throw in self.engine_file.crank_throws]
        sections: dict[int, float] = {}
        for element in range(cranks.crank_elements):
            ends = cranks.chain.connections[element]
            joined = [
                moduli[cranks.throw_nodes.index(node)]
                for node in ends
                if node in cranks.throw_nodes
            ]
            if joined:  # of a plant, parts before the first crank have no section that is known
                sections[element] = min(joined)
        return sections

    def at(self, harmonics: CylinderHarmonics, speeds: Array) -> Answers:
        """Return the axial and the torsional vibration at speeds [rad/s], ascending."""
        return self.answers(forces_over_speeds(self.engine_file, harmonics, speeds))

    def answers(self, forces: CylinderForces, *, propeller: bool = True) -> Answers:
        """Return the axial and the torsional vibration under forces of the cylinders.

        Parameters
        ----------
        propeller : bool, optional
            Whether the propeller excites too. Without it the response is linear in the forces.
        """
        file = self.engine_file
        torques = torque_excitation(forces, self.cranks)
        if propeller:
            torques = with_propeller(file, self.cranks, torques)
        twisted = forced_response(self.damped[1], torques)
        pressed, by_torque, remarks = excitation_along_shaft(
            file, forces, self.pulled, self.shaft, self.cranks, twisted
        )
        if propeller:
            pressed = with_propeller(file, self.pulled.chain, pressed)
        lengthened = forced_response(self.damped[0], pressed)
        return (
            ChainAnswer(self.pulled.chain, lengthened, {}, by_torque, remarks),
            ChainAnswer(self.cranks, twisted, self.moduli),
        )


def cause_at(
    answer: ChainAnswer,
    torsional: ChainAnswer,
    series: OrderSeries,
    place: str,
    speed: float,
    unit: str,
) -> PeakCause:
    """Find the orders responsible for what is reached at a place and a speed [rad/s].

    Parameters
    ----------
    answer, torsional : ChainAnswer
        The vibration, and the torsional one, which also drives the axial one.
    series : OrderSeries
        Of the vibration, with that place [unit].
    """
    index = int(np.argmin(np.abs(series.speeds - speed)))
    driven = None
    if answer.by_torque is not None:
        # The torsional vibration that stretches the shaft is largest in one of its elements.
        elements = torsional.crank_elements
        largest = int(np.argmax(elements.synthesis.amplitude[index]))
        twist = peak_cause(
            torsional.response, elements, largest, index, kind="torsional", modes=torsional.modes
        )
        driven = (answer.by_torque, twist)
    kind = answer.engine_chain.kind
    return peak_cause(
        answer.response,
        series,
        place,
        index,
        unit=unit,
        kind=kind,
        modes=answer.modes,
        driven=driven,
    )


def first_places(series: OrderSeries, count: int) -> OrderSeries:
    """Return the first locations of a series."""
    return replace(series, values=series.values[:, :, :count], names=series.names[:count])


def nominal_section_modulus(throw: Throw) -> float:
    """Section modulus of the weaker of main journal and crankpin in torsion [m^3]."""
    moduli = section_modulus(
        "torsional",
        [throw.main_journal_diameter, throw.pin_diameter],
        [throw.main_journal_bore, throw.pin_bore],
    )
    return float(min(moduli))
