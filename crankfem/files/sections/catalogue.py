"""All sections of engine files: the model of each, and for what it is needed."""

from dataclasses import dataclass

from crankbase.model import InputModel
from crankfem.files.sections.engine_sections import (
    Engine,
    Flywheel,
    FreeEnd,
    NamedThrow,
    ShaftLayout,
    ThrustBearing,
    TorqueTable,
    TwoMassInput,
    VibrationSettings,
)
from crankfem.files.sections.excitation_sections import GasMap, Misfire, PropellerForcesSection
from crankfem.files.sections.limits_sections import LimitsInput, RangesInput
from crankfem.files.sections.mechanism_sections import Gas, HingedRods, Piston, Rod
from crankfem.files.sections.vibration_sections import (
    AxialDamper,
    Bearings,
    Damping,
    Driven,
    ShaftLineFiles,
    TorsionalDamper,
)
from fem.material import Material
from geometry.shaft_ends import ShaftEnds
from geometry.throw import CrankThrow


@dataclass(frozen=True)
class EngineSection:
    """A section: its model, None for a study; for what it is needed; whether a whole engine needs it."""

    model: type[InputModel] | None
    need: str = "optional"
    required: bool = False


MECHANISM, WHOLE_ENGINE = "required for more than a throw", "required for run and vibration"

SECTIONS = {
    "engine": EngineSection(Engine, MECHANISM, required=True),
    "throw": EngineSection(CrankThrow, "required", required=True),
    "throws": EngineSection(
        NamedThrow, "optional, in place of [throw]; with all fields of [throw] and"
    ),
    "shaft": EngineSection(ShaftLayout),
    "shaft_ends": EngineSection(ShaftEnds),
    "material": EngineSection(Material, "optional, steel by default"),
    "rod": EngineSection(Rod, MECHANISM, required=True),
    "piston": EngineSection(Piston, MECHANISM, required=True),
    "hinged_rods": EngineSection(HingedRods),
    "flywheel": EngineSection(Flywheel, WHOLE_ENGINE, required=True),
    "free_end": EngineSection(FreeEnd),
    "thrust_bearing": EngineSection(ThrustBearing, WHOLE_ENGINE, required=True),
    "damping": EngineSection(Damping),
    "torsional_damper": EngineSection(TorsionalDamper),
    "axial_damper": EngineSection(AxialDamper),
    "driven": EngineSection(Driven),
    "bearings": EngineSection(Bearings),
    "shaft_line": EngineSection(ShaftLineFiles),
    "gas": EngineSection(Gas, "optional; without it reactions are given for 100 kN"),
    "gas_map": EngineSection(GasMap),
    "misfire": EngineSection(Misfire),
    "propeller_forces": EngineSection(PropellerForcesSection),
    "limits": EngineSection(LimitsInput),
    "ranges": EngineSection(RangesInput),
    "vibration": EngineSection(VibrationSettings),
    "torque": EngineSection(TorqueTable),
    "two_mass_check": EngineSection(TwoMassInput),
    "study": EngineSection(None),
}
