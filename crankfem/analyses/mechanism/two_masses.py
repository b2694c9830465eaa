"""An engine as two masses on one shaft: resonant orders and their excitation."""

import math
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from crankbase.errors import InputError
from crankbase.quantity import RPM
from crankfem.analyses.mechanism.mechanism_records import fired_record, seen_stars
from crankfem.analyses.record import Record, attributes
from crankfem.files.engine.file_kinds import torque_table_file
from crankfem.files.reading.toml_file import TomlFile
from crankfem.files.sections.engine_sections import Engine, TwoMassInput, VibrationSettings
from dynamics.critical import TwoMassCheck, critical_speeds, engine_orders, two_mass_check
from dynamics.harmonics import Harmonics, read_torque_table


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
    given: TwoMassInput
    engine: Engine | None
    highest_order: float | None
    harmonics: Harmonics | None

    def check(self, order: float | None = None) -> TwoMassCheck:
        """Return the check for an order, that of the file by default."""
        return checked(self.given, self.harmonics, order)


def checked(
    given: TwoMassInput, harmonics: Harmonics | None, order: float | None = None
) -> TwoMassCheck:
    """Return the check of a section [two_mass_check], for its own order by default."""
    return two_mass_check(
        diameter=given.shaft_diameter,
        length=given.shaft_length,
        shear_modulus=given.shear_modulus,
        inertia_1=given.flywheel_inertia,
        inertia_2=given.engine_inertia,
        order=given.order if order is None else order,
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
        given=model,
        engine=engine,
        highest_order=None if settings is None else settings.highest_order,
        harmonics=None if table is None else read_torque_table(table, strokes=strokes).harmonics(),
    )


def two_mass_record(check: TwoMassCheck) -> Record:
    """The two-mass check."""
    return {
        **attributes(check, "stiffness", "angular_frequency", "vibrations_per_minute", "order"),
        **attributes(check, "resonant_speed_rpm", "statement"),
        "frequency": check.angular_frequency / (2.0 * math.pi),
    }


def two_mass_run_record(file: TwoMassFile, order: float | None = None) -> Record:
    """Return the check, the resonances at running speeds and the torque in the shaft, in SI units.

    Parameters
    ----------
    order : float, optional
        Replaces the file's.

    Returns
    -------
    dict
        "resonances" and "running_rpm" are null without a section [engine], "shaft_torque" also without a
        torque table.
    """
    check, engine = file.check(order), file.engine
    record = {"file": file.path.name} | two_mass_record(check)
    return record | {
        "running_rpm": None
        if engine is None
        else [engine.lowest_speed * RPM, engine.highest_speed * RPM],
        "highest_order": None if engine is None else _highest_order(file, check),
        "resonances": None if engine is None else _resonances(file, check, engine),
        "shaft_torque": None
        if engine is None or file.harmonics is None
        else _shaft_torque(file, check, engine, file.harmonics),
    }


def _highest_order(file: TwoMassFile, check: TwoMassCheck) -> float:
    return max(check.order, file.highest_order or 0.0)


def _resonances(file: TwoMassFile, check: TwoMassCheck, engine: Engine) -> list[Record]:
    """Speeds in the running range at which orders meet the natural frequency, by falling order."""
    highest = _highest_order(file, check)
    running = (engine.lowest_speed, engine.highest_speed)
    resonances = critical_speeds([check.frequency], engine_orders(engine.strokes, highest), running)
    table = file.harmonics
    return [
        {
            "order": resonance.order,
            "speed_rpm": resonance.speed_rpm,
            "amplitude": float(table.amplitude[table.index_of(resonance.order)])
            if table is not None and table.resolves(resonance.order)
            else None,
        }
        for resonance in resonances
    ]


def _shaft_torque(
    file: TwoMassFile, check: TwoMassCheck, engine: Engine, harmonics: Harmonics
) -> Record:
    """Torque in the shaft by the cylinders' harmonics at rated speed, without damping.

    The torque M_k on the engine's inertia J_np causes J_MAX / (J_MAX + J_np) of it in the shaft while the
    order is far below resonance, and 1 / (1 - (k w / w_c1)^2) times as much near it.
    """
    firing = np.degrees(engine.firing_angles).tolist()
    stars = seen_stars(harmonics, firing)
    torque = fired_record(harmonics, stars, firing)["torque"]
    given = file.given
    passed = given.flywheel_inertia / (given.flywheel_inertia + given.engine_inertia)
    orders, amplitude = (np.array(torque[name]) for name in ("orders", "amplitude"))
    nearness = 1.0 - (orders * engine.rated_speed / check.angular_frequency) ** 2
    magnified = [1.0 / near if near != 0.0 else None for near in nearness.tolist()]
    return {
        "speed_rpm": engine.rated_speed * RPM,
        "orders": orders.tolist(),
        "exciting": amplitude.tolist(),
        "magnification": magnified,
        "torque": [
            None if by is None else passed * abs(by) * own
            for by, own in zip(magnified, amplitude.tolist(), strict=True)
        ],
    }
