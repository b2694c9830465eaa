"""An engine as two masses on one shaft: resonant orders and their excitation."""

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Annotated

import numpy as np

from crankbase.array_checks import Array
from crankbase.errors import InputError
from crankbase.quantity import RPM
from crankbase.results import Flat, Number, Quantity, Result, Speed, result
from crankbase.sentences import amount
from crankbase.table import SI, Column, Main, OutputUnits, Table, table_unit
from crankfem.analyses.mechanism.torque_harmonics import summed_cylinders
from crankfem.files.reading.toml_file import TomlFile
from crankfem.files.sections.engine_sections import (
    Engine,
    TwoMassInput,
    VibrationSettings,
    torque_table_file,
)
from dynamics.critical import TwoMassCheck, critical_speeds, engine_orders, two_mass_check
from dynamics.harmonics import Harmonics, read_torque_table
from dynamics.wording import speed_range

NewtonMeter = Annotated[float, Quantity("N m")]
NewtonMeters = Annotated[Array, Quantity("N m")]
# Of the largest exciting torque; below are cylinders that cancel each other.
LEAST_SHARE = 1e-9


@dataclass(frozen=True, eq=False)
class TwoMassFile:
    """Data of an engine as two masses, from a file.

    Parameters
    ----------
    engine : Engine or None
        Its speeds and firing angles, if the file has the section.
    highest_order : float or None
        Of the section [vibration].
    harmonics : Harmonics or None
        Of the torque of one throw, if the file names a table [N m].
    """

    path: Path
    section: TwoMassInput
    engine: Engine | None
    highest_order: float | None
    harmonics: Harmonics | None

    def check(self, order: float | None = None) -> TwoMassCheck:
        """Return the check for an order, that of the file by default."""
        return checked(self.section, self.harmonics, order)


def checked(
    section: TwoMassInput, harmonics: Harmonics | None, order: float | None = None
) -> TwoMassCheck:
    """Return the check of a section [two_mass_check], for its own order by default."""
    return two_mass_check(
        diameter=section.shaft_diameter,
        length=section.shaft_length,
        shear_modulus=section.shear_modulus,
        inertia_1=section.flywheel_inertia,
        inertia_2=section.engine_inertia,
        order=section.order if order is None else order,
        harmonics=harmonics,
    )


def read_two_masses(content: TomlFile) -> TwoMassFile:
    """Read the section [two_mass_check], and [engine], [vibration] and [torque] if they are there.

    Raises
    ------
    InputError
        If the section is missing, or one cannot be read.
    """
    model = content.model("two_mass_check", TwoMassInput)
    if model is None:
        raise InputError(
            f"{content.path.name}: the section [two_mass_check] is missing; it is required here, because it "
            "defines the shaft and the inertias (crankfem fields two_mass_check)."
        )
    engine = content.model("engine", Engine)
    settings = content.model("vibration", VibrationSettings)
    table = torque_table_file(content)
    strokes = None if engine is None else engine.strokes
    return TwoMassFile(
        path=content.path,
        section=model,
        engine=engine,
        highest_order=None if settings is None else settings.highest_order,
        harmonics=None if table is None else read_torque_table(table, strokes=strokes).harmonics(),
    )


@result("order", "speed", "amplitude")
class ExcitedResonance(Result):
    """A running speed at which an order meets the natural frequency, and M_k of one throw if known."""

    order: Number
    speed: Speed
    amplitude: NewtonMeter | None


@result("speed", "orders", "torque")
class ShaftTorque(Result):
    """Torque in the shaft at one speed by the cylinders' harmonics, without damping; inf at resonance."""

    speed: Speed
    orders: Annotated[Array, Quantity("1")]
    exciting: NewtonMeters
    magnification: Annotated[Array, Quantity("1")]
    torque: NewtonMeters

    def table(self, units: OutputUnits) -> Table:
        """Return the orders that do not cancel."""
        shown = table_unit(self.exciting, "N m", units)
        unit, decimals = shown.column("").unit, shown.decimals
        values = zip(self.orders, self.exciting, self.magnification, self.torque, strict=True)
        return Table(
            units.written(
                f"Torque in the shaft at {amount(self.speed, 'rad/s', 4)}, without damping, by the table's "
                "orders that do not cancel"
            ),
            [
                Column("order", digits=None),
                shown.column("M_k of all cylinders"),
                Column("magnification", missing="unbounded"),
                Column("in the shaft", unit, missing="unbounded", decimals=decimals),
            ],
            [
                [value if math.isfinite(value) else None for value in row]
                for row in values
                if row[1] > LEAST_SHARE * np.max(self.exciting)
            ],
        )


@result("file", "check", "resonances")
class TwoMassRun(Result):
    """Check of two masses, resonances at running speeds and torque in the shaft.

    Parameters
    ----------
    running : tuple of two floats or None
        Lowest and highest speed; like the resonances None without a section [engine].
    shaft_torque : ShaftTorque or None
        None also without a torque table.
    """

    file: str
    check: Flat[TwoMassCheck]
    running: Annotated[tuple[float, float] | None, Quantity("rad/s", exported="1/min")]
    highest_order: Number | None
    resonances: tuple[ExcitedResonance, ...] | None
    shaft_torque: ShaftTorque | None

    def parts(self, units: OutputUnits = SI) -> Iterator[Table | str]:
        """Return tables and sentences."""
        check, rpm, within = self.check, self.check.resonant_speed_rpm, ""
        yield Main(
            units.written(
                f"Two masses on one shaft of {check.stiffness / 1e3:.4g} kN m/rad: natural frequency "
                f"{amount(check.frequency, 'Hz', decimals=2)}, "
                f"{amount(check.angular_frequency, 'rad/s', 5, shown='rad/s')}, "
                f"{check.vibrations_per_minute:.5g} vibrations per minute."
            )
        )
        if self.running is not None:
            low, high = self.running
            where = "inside" if low * RPM <= rpm <= high * RPM else "outside"
            within = f", {where} the running range of {speed_range(low, high)}"
        if self.resonances:
            yield Table(
                f"Resonances in the running range, orders up to {self.highest_order:g}",
                [
                    Column("order", digits=None),
                    Column("speed", "1/min", decimals=1),
                    Column("M_k of one throw", "N m", missing="not resolved"),
                ],
                [[row.order, row.speed, row.amplitude] for row in self.resonances],
                main=True,
            )
        if self.shaft_torque is not None:
            yield replace(self.shaft_torque.table(units), main=True)
        yield Main(units.written(check.statement))
        speed = amount(rpm / RPM, "rad/s", decimals=1)
        yield Main(units.written(f"Order {check.order:g} resonates at {speed}{within}."))


def run_two_masses(file: TwoMassFile, order: float | None = None) -> TwoMassRun:
    """Check two masses, for the file's order by default."""
    check, engine, table = file.check(order), file.engine, file.harmonics
    if engine is None:
        return TwoMassRun(file.path.name, check, None, None, None, None)
    highest, running = (
        max(check.order, file.highest_order or 0.0),
        (engine.lowest_speed, engine.highest_speed),
    )
    shaft_torque = None
    if table is not None:
        # The torque M_k on the engine's inertia J_np causes J_MAX / (J_MAX + J_np) of it in the shaft while
        # the order is far below resonance, and 1 / (1 - (k w / w_c1)^2) times as much near it.
        section = file.section
        torque = summed_cylinders(table, np.degrees(engine.firing_angles).tolist()).torque
        passed = section.flywheel_inertia / (section.flywheel_inertia + section.engine_inertia)
        nearness = 1.0 - (torque.orders * engine.rated_speed / check.angular_frequency) ** 2
        with np.errstate(divide="ignore"):
            magnification = np.where(nearness == 0.0, np.inf, 1.0 / nearness)
            inside = np.where(
                nearness == 0.0, np.inf, passed * np.abs(magnification) * torque.amplitude
            )
        shaft_torque = ShaftTorque(
            engine.rated_speed, torque.orders, torque.amplitude, magnification, inside
        )
    return TwoMassRun(
        file.path.name,
        check,
        running,
        highest,
        tuple(
            ExcitedResonance(
                meeting.order,
                meeting.speed,
                float(table.amplitude[table.index_of(meeting.order)])
                if table is not None and table.resolves(meeting.order)
                else None,
            )
            for meeting in critical_speeds(
                [check.frequency], engine_orders(engine.strokes, highest), running
            )
        ),
        shaft_torque,
    )
