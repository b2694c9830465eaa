"""Forced vibration of an engine's chains over its speeds, under the forces of its cylinders."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
from numpy.typing import ArrayLike

from crankfem.choices import check_choice
from crankfem.engine_file import EngineFile
from crankfem.pictures.vibration_panels import MOTION, most_stressed
from crankfem.vibration.chains import damped_engine_chain
from crankfem.vibration.excitation import (
    Frequencies,
    acting_remarks,
    compared_axial_forces,
    excitation_along_shaft,
    forces_over_speeds,
    with_propeller,
)
from crankfem.vibration.modes import Vibration
from dynamics.chains.engine_chains import EngineChain
from dynamics.critical import major_orders
from dynamics.excitation.axial_comparison import AxialForceComparison
from dynamics.excitation.cylinder_harmonics import CylinderHarmonics
from dynamics.excitation.cylinders import CylinderForces
from dynamics.excitation.on_chains import torque_excitation
from dynamics.plots.quantities import Quantity
from dynamics.response.forced import ForcedResponse, forced_response
from dynamics.response.loads import ElementLoads, alternating_stress, element_loads, section_modulus
from dynamics.response.power import PowerBalance, power_balance
from dynamics.response.resonance import Resonance, resonances
from dynamics.response.series import OrderSeries
from fem.analysis import ThrowAnalysis
from fem.shaft import ShaftCompliances
from geometry.errors import InputError
from geometry.frames import table_of
from geometry.plots.legends import write_title
from geometry.throw import CrankThrow

if TYPE_CHECKING:
    from matplotlib.axes import Axes

Forced = Literal["amplitude", "load", "stress", "power", "axial forces"]
FORCED: tuple[Forced, ...] = ("amplitude", "load", "stress", "power", "axial forces")


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

    def plot(
        self,
        axes: "Axes | None" = None,
        *,
        show: Forced = "amplitude",
        limits: Mapping[str, ArrayLike] | None = None,
        barred: Sequence[tuple[float, float]] = (),
    ) -> "Axes":
        """Draw one thing over the speeds of the engine.

        Parameters
        ----------
        axes : matplotlib.axes.Axes, optional
            New ones by default.
        show : {"amplitude", "load", "stress", "power", "axial forces"}
            Motion of the free end; torque or force in the crankshaft's element that is loaded most;
            nominal stress in the one that is stressed most; power in and out; the exciting axial
            force of the first throw.
        limits : mapping of str to (S,) array_like, optional
            Limits over the response's speeds by their name, of the first three [SI].
        barred : sequence of (low, high), optional
            Speed ranges to shade [rad/s].

        Returns
        -------
        matplotlib.axes.Axes

        Raises
        ------
        InputError
            If `show` is none of these, or this kind of vibration has none.
        """
        check_choice("show", show, FORCED, "these are drawn over the speed")
        if show == "power":
            return self.power.plot(axes)
        if show == "axial forces":
            if self.axial_forces is None:
                raise self._missing(show)
            return self.axial_forces.plot(axes)
        axial = self.kind == "axial"
        if show == "stress":
            if self.stress is None:
                raise self._missing(show)
            place = most_stressed(self)
            return self.stress.plot(axes, place, "stress", limits=limits, barred=barred)
        if show == "load":
            series = self.crank_elements
            worst = int(np.argmax(np.max(series.synthesis.amplitude, axis=0)))
            quantity: Quantity = "force" if axial else "torque"
            return series.plot(axes, worst, quantity, limits=limits, barred=barred)
        axes = self.free_end.plot(axes, 0, MOTION[self.kind], limits=limits, barred=barred)
        write_title(axes, f"{self.kind.capitalize()} vibration of the free end")
        return axes

    def to_pandas(self) -> Any:
        """Return a table of the resonances in the running range, with the free end's amplitude.

        Returns
        -------
        pandas.DataFrame
            Units are in ``frame.attrs["units"]``.

        Raises
        ------
        MissingLibraryError
            If pandas is not installed.
        """
        return table_of(self.resonances)

    def to_xarray(self) -> Any:
        """Return the motion of all nodes over orders and speeds; see `ForcedResponse.to_xarray`."""
        return self.response.to_xarray(MOTION[self.kind])

    def _missing(self, show: str) -> InputError:
        return InputError(
            f"show: given {show!r}; allowed for {self.kind} vibration are the others, because that is "
            "calculated for the other kind only."
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
        On one grid of speeds, that of `forces_over_speeds`. Axial vibration is excited by the radial
        forces and by the torques of the torsional vibration.
    """
    chains = [damped_engine_chain(engine_file, own.chosen.chain) for own in (axial, torsional)]
    forces = forces_over_speeds(engine_file, harmonics, chains, further)
    cranks = torsional.chosen.chain
    twisted = forced_response(
        chains[1], with_propeller(engine_file, cranks, torque_excitation(forces, cranks))
    )
    pressed, remarks = excitation_along_shaft(
        engine_file, forces, axial.chosen, shaft, cranks, twisted
    )
    lengthened = forced_response(
        chains[0], with_propeller(engine_file, axial.chosen.chain, pressed)
    )
    loads = element_loads(twisted)
    return (
        ForcedVibration(
            kind="axial",
            engine_chain=axial.chosen.chain,
            damping=chains[0].record,
            remarks=(*acting_remarks(engine_file, "axial"), *remarks),
            forces=forces,
            response=lengthened,
            loads=element_loads(lengthened),
            stress=None,
            power=power_balance(lengthened),
            resonances=_resonances(engine_file, lengthened),
            axial_forces=compared_axial_forces(
                forces, axial.chosen.compliances, shaft, analysis, engine_file.pins
            ),
        ),
        ForcedVibration(
            kind="torsional",
            engine_chain=cranks,
            damping=chains[1].record,
            remarks=acting_remarks(engine_file, "torsional"),
            forces=forces,
            response=twisted,
            loads=loads,
            stress=alternating_stress(loads, _sections(engine_file.throw, cranks)),
            power=power_balance(twisted),
            resonances=_resonances(engine_file, twisted),
            axial_forces=None,
        ),
    )


def _resonances(engine_file: EngineFile, response: ForcedResponse) -> tuple[Resonance, ...]:
    """Resonances at running speeds; major are those of orders in which all cylinders fire in phase."""
    engine = engine_file.engine
    major = major_orders(response.orders, engine.firing_angles)
    found = resonances(response, 0, speed_range=(engine.lowest_speed, engine.highest_speed))
    return tuple(
        replace(one, kind="major" if np.any(np.isclose(major, one.order)) else "minor")
        for one in found
    )


def nominal_section_modulus(throw: CrankThrow) -> float:
    """Section modulus of the weaker of main journal and crankpin in torsion [m^3]."""
    moduli = section_modulus(
        "torsional",
        [throw.main_journal_diameter, throw.pin_diameter],
        [throw.main_journal_bore, throw.pin_bore],
    )
    return float(np.min(moduli))


def _crank_elements(chain: EngineChain) -> int:
    """Number of elements between free end (or first throw) and flywheel, the first of the chain."""
    if chain.kind == "axial":
        return chain.throws
    return chain.throw_nodes[-1] + 1


def _sections(throw: CrankThrow, chain: EngineChain) -> dict[int, float]:
    return dict.fromkeys(range(_crank_elements(chain)), nominal_section_modulus(throw))
