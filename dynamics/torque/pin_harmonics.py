"""Harmonics of the force of each cylinder on its crankpin, for vibration models."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from crankbase.checks.arrays import FloatArray
from crankbase.checks.choices import check_choice
from crankbase.library_types import Axes, DataFrame
from crankbase.summaries import summarized
from crankbase.tables.frames import table
from dynamics.engine.gas_forces import Pressure
from dynamics.engine.layout import EngineLayout
from dynamics.gas.pressure import ATMOSPHERE
from dynamics.harmonics import Harmonics
from dynamics.mechanism.rod_model_names import RodModelName
from dynamics.plots.harmonics import draw_harmonics
from dynamics.plots.quantities import KILO
from dynamics.torque.cycle_samples import (
    DEFAULT_SAMPLES,
    forces_by_cause,
    from_firing_top,
    samples_and_gas,
)


@summarized(
    "number",
    "firing_angle_deg [deg]",
    "tangential: tangential.amplitude [N]",
    "radial: radial.amplitude [N]",
)
@dataclass(frozen=True, eq=False)
class PinForceHarmonics:
    """Harmonics of one cylinder's force on its crankpin, by its cause [N].

    Phases count from the cylinder's own firing top: a harmonic of order k is
    M_k sin(k (shaft angle - firing angle) + a_k).

    Parameters
    ----------
    number : int
        Of the cylinder.
    firing_angle_deg : float
        Shaft angle of its firing top [deg].
    tangential_gas, tangential_inertia, tangential : Harmonics
        T, in the sense of rotation: of the gas, of moving masses, of both. Crank radius times T is
        the torque.
    radial_gas, radial_inertia, radial : Harmonics
        Z, towards the shaft axis.
    """

    number: int
    firing_angle_deg: float
    tangential_gas: Harmonics
    tangential_inertia: Harmonics
    tangential: Harmonics
    radial_gas: Harmonics
    radial_inertia: Harmonics
    radial: Harmonics

    def plot(
        self,
        axes: Axes | None = None,
        *,
        show: Literal["tangential", "radial"] = "tangential",
        highest_order: float | None = None,
    ) -> Axes:
        """Draw the amplitudes of T or Z by order: of the gas, of moving masses, of both.

        Parameters
        ----------
        axes : matplotlib.axes.Axes, optional
            Where to draw; new axes by default.
        show : {"tangential", "radial"}, optional
            Which of the forces on the crankpin.
        highest_order : float, optional
            Highest order drawn; all by default.

        Returns
        -------
        matplotlib.axes.Axes

        Raises
        ------
        InputError
            If there is no such force, or no order is left.
        """
        check_choice("show", show, ("tangential", "radial"), "these are the forces on a crankpin")
        found = {
            name: getattr(self, show + ending)
            for name, ending in (("gas", "_gas"), ("inertia", "_inertia"), ("both", ""))
        }
        if highest_order is not None:
            found = {name: own.up_to(highest_order) for name, own in found.items()}
        bars = {name: KILO * own.amplitude for name, own in found.items()}
        title = f"Harmonics of the {show} force, cylinder {self.number}"
        return draw_harmonics(axes, found["both"].orders, bars, "amplitude [kN]", title=title)

    def to_pandas(self) -> DataFrame:
        """Return one row for each order: amplitude and phase of T and Z by cause.

        Returns
        -------
        pandas.DataFrame
            Units of the columns in ``attrs["units"]``.

        Raises
        ------
        MissingLibraryError
            If pandas is not installed.
        """
        columns: dict[str, tuple[FloatArray, str]] = {"order": (self.tangential.orders, "1")}
        for name in CAUSES:
            own: Harmonics = getattr(self, name)
            columns[name] = (own.amplitude, "N")
            columns[f"{name}_phase"] = (own.phase, "rad")
        return table(columns)


CAUSES = (
    "tangential_gas",
    "tangential_inertia",
    "tangential",
    "radial_gas",
    "radial_inertia",
    "radial",
)


def pin_force_harmonics(
    engine: EngineLayout,
    speed: float,
    pressure: Pressure | Sequence[Pressure] | ArrayLike | None = None,
    *,
    highest_order: float = 24.0,
    samples: int = DEFAULT_SAMPLES,
    model: RodModelName = "rigid",
    crankcase_pressure: float = ATMOSPHERE,
) -> tuple[PinForceHarmonics, ...]:
    """Find the harmonics of the tangential and the radial force on the crankpin, by cylinder.

    Parameters
    ----------
    engine, speed, pressure, samples, model, crankcase_pressure
        As for `engine_torque`.
    highest_order : float, optional
        Highest order; the samples must resolve it.

    Returns
    -------
    tuple of n PinForceHarmonics

    Raises
    ------
    InputError
        As `engine_torque`, and if the samples do not resolve the highest order.
    """
    angles, gas = samples_and_gas(engine, pressure, samples, crankcase_pressure)
    of_gas, of_masses = forces_by_cause(engine, speed, angles, gas, model)
    parts: list[FloatArray] = []
    for by_gas, by_masses in (
        (of_gas.tangential, of_masses.tangential),
        (of_gas.radial, of_masses.radial),
    ):
        parts += [by_gas, by_masses, by_gas + by_masses]
    found = []
    for place, firing in enumerate(np.radians(engine.firing_deg)):
        split = [
            from_firing_top(engine, place, angles, part[place]).up_to(highest_order)
            for part in parts
        ]
        found.append(PinForceHarmonics(place + 1, math.degrees(firing), *split))
    return tuple(found)
