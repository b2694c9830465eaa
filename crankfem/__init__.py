"""crankfem: axial and torsional vibration of crankshafts, from crank-throw dimensions to a verdict.

Everything a user needs has a name here; the packages behind it are internal. Names are loaded when
first used, so that looking a compliance up does not load a mesher.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

from crankfem._packages import check_packages

check_packages()

if TYPE_CHECKING:
    from crankfem.engine_file import EngineFile, load_crankshaft, load_engine, load_throw
    from crankfem.pictures.drawing import draw_throw
    from crankfem.pictures.solid_picture import picture_shaft, picture_throw
    from crankfem.pictures.stress_picture import picture_stresses
    from crankfem.pipeline import RunResult, run_engine
    from crankfem.studies import StudyResult, run_study
    from dynamics.chain import Chain, Modes
    from dynamics.critical import CriticalSpeed, critical_speeds, engine_orders
    from dynamics.engine.cylinder import EngineCylinder, RotatingMass, SlavePin
    from dynamics.engine.forces import MechanismForces, mechanism_forces
    from dynamics.engine.gas_forces import gas_forces
    from dynamics.engine.layout import EngineLayout
    from dynamics.engine.motions import cylinder_motion, reduced_inertia
    from dynamics.harmonics import Harmonics, harmonics
    from dynamics.mechanism.rods import ConnectingRod, RodModel
    from dynamics.mechanism.slider_crank import SliderCrank
    from dynamics.torque_table import TorqueTable, read_torque_table
    from dynamics.two_mass import TwoMassCheck, two_mass_check
    from fem.analysis import AxialAnalysis, ThrowAnalysis, analyze_axial, analyze_throw
    from fem.angle_law import AngleLaw
    from fem.calculix import write_calculix
    from fem.craig_bampton import (
        DynamicSuperelement,
        assemble_dynamic_shaft,
        natural_modes,
    )
    from fem.fillet_stress import FilletPeak, FilletStresses, fillet_stresses
    from fem.material import STEEL, Material
    from fem.modes import ThrowModes
    from fem.pin_response import Motion, PinResponse
    from fem.shaft import ShaftCompliances, shaft_compliances
    from fem.solver import SolveError
    from fem.supports import EndReaction, Neighbors, Reactions
    from geometry.balance import Unbalance, unbalance
    from geometry.crankshaft import Crankshaft, throw_masses
    from geometry.errors import InputError, MeshError, MissingLibraryError
    from geometry.imported import ImportedThrow, import_throw
    from geometry.mass import MassProperties
    from geometry.mesh import ThrowMesh
    from geometry.mesh_files import write_mesh
    from geometry.mesher import mesh_isolated as mesh_throw
    from geometry.shaft_ends import ShaftEnds
    from geometry.solid_files import write_step
    from geometry.throw import CrankThrow
    from geometry.throw_sections import Counterweight, FurtherPin, Web
    from regression.formulas.axial_formulas import axial_formula, axial_formulas
    from regression.formulas.formula_value import FormulaValue
    from regression.formulas.torsional_formulas import torsional_formulas
    from regression.models.compliance_model import ComplianceModel, Lookup, OutsideRangeWarning
    from regression.models.optimum import Optimum, find_optimum
    from regression.models.optimum_limits import Limit

# Where each public name lives.
_HOMES = {
    name: home
    for home, names in {
        "crankfem.engine_file": (
            "EngineFile",
            "load_crankshaft",
            "load_throw",
            "load_engine",
        ),
        "crankfem.pictures.drawing": ("draw_throw",),
        "crankfem.pictures.solid_picture": (
            "picture_shaft",
            "picture_throw",
        ),
        "crankfem.pipeline": (
            "RunResult",
            "run_engine",
        ),
        "crankfem.studies": (
            "StudyResult",
            "run_study",
        ),
        "dynamics.chain": (
            "Chain",
            "Modes",
        ),
        "dynamics.critical": (
            "CriticalSpeed",
            "critical_speeds",
            "engine_orders",
        ),
        "dynamics.engine.cylinder": ("EngineCylinder", "RotatingMass", "SlavePin"),
        "dynamics.engine.forces": ("MechanismForces", "mechanism_forces"),
        "dynamics.engine.gas_forces": ("gas_forces",),
        "dynamics.engine.layout": ("EngineLayout",),
        "dynamics.engine.motions": ("cylinder_motion", "reduced_inertia"),
        "dynamics.mechanism.rods": ("ConnectingRod", "RodModel"),
        "dynamics.mechanism.slider_crank": ("SliderCrank",),
        "dynamics.harmonics": (
            "Harmonics",
            "harmonics",
        ),
        "dynamics.torque_table": (
            "TorqueTable",
            "read_torque_table",
        ),
        "dynamics.two_mass": (
            "TwoMassCheck",
            "two_mass_check",
        ),
        "fem.analysis": (
            "AxialAnalysis",
            "ThrowAnalysis",
            "analyze_axial",
            "analyze_throw",
        ),
        "fem.calculix": ("write_calculix",),
        "fem.fillet_stress": (
            "FilletPeak",
            "FilletStresses",
            "fillet_stresses",
        ),
        "crankfem.pictures.stress_picture": ("picture_stresses",),
        "fem.craig_bampton": (
            "DynamicSuperelement",
            "assemble_dynamic_shaft",
            "natural_modes",
        ),
        "fem.modes": ("ThrowModes",),
        "fem.pin_response": (
            "Motion",
            "PinResponse",
        ),
        "fem.material": (
            "STEEL",
            "Material",
        ),
        "fem.shaft": (
            "ShaftCompliances",
            "shaft_compliances",
        ),
        "fem.solver": ("SolveError",),
        "fem.supports": (
            "EndReaction",
            "Neighbors",
            "Reactions",
        ),
        "geometry.balance": (
            "Unbalance",
            "unbalance",
        ),
        "geometry.crankshaft": (
            "Crankshaft",
            "throw_masses",
        ),
        "geometry.imported": (
            "ImportedThrow",
            "import_throw",
        ),
        "geometry.mass": ("MassProperties",),
        "geometry.mesh": ("ThrowMesh",),
        "geometry.mesh_files": ("write_mesh",),
        "geometry.mesher": ("mesh_throw",),
        "geometry.solid_files": ("write_step",),
        "geometry.errors": (
            "InputError",
            "MeshError",
            "MissingLibraryError",
        ),
        "geometry.shaft_ends": ("ShaftEnds",),
        "geometry.throw": ("CrankThrow",),
        "geometry.throw_sections": (
            "Counterweight",
            "FurtherPin",
            "Web",
        ),
        "regression.formulas.axial_formulas": (
            "axial_formula",
            "axial_formulas",
        ),
        "regression.models.compliance_model": (
            "ComplianceModel",
            "Limit",
            "Lookup",
            "OutsideRangeWarning",
        ),
        "regression.formulas.formula_value": ("FormulaValue",),
        "regression.models.optimum": ("Optimum", "find_optimum"),
        "regression.models.optimum_limits": ("Limit",),
        "fem.angle_law": ("AngleLaw",),
        "regression.formulas.torsional_formulas": ("torsional_formulas",),
    }.items()
    for name in names
}

# Public names that are not those at home: users mesh in a process of its own.
_OTHER_NAMES = {"mesh_throw": "mesh_isolated"}

__all__ = [
    "STEEL",
    "AngleLaw",
    "AxialAnalysis",
    "Chain",
    "ComplianceModel",
    "ConnectingRod",
    "Counterweight",
    "CrankThrow",
    "Crankshaft",
    "CriticalSpeed",
    "DynamicSuperelement",
    "EndReaction",
    "EngineCylinder",
    "EngineFile",
    "EngineLayout",
    "FilletPeak",
    "FilletStresses",
    "FormulaValue",
    "FurtherPin",
    "Harmonics",
    "ImportedThrow",
    "InputError",
    "Limit",
    "Lookup",
    "MassProperties",
    "Material",
    "MechanismForces",
    "MeshError",
    "MissingLibraryError",
    "Modes",
    "Motion",
    "Neighbors",
    "Optimum",
    "OutsideRangeWarning",
    "PinResponse",
    "Reactions",
    "RodModel",
    "RotatingMass",
    "RunResult",
    "ShaftCompliances",
    "ShaftEnds",
    "SlavePin",
    "SliderCrank",
    "SolveError",
    "StudyResult",
    "ThrowAnalysis",
    "ThrowMesh",
    "ThrowModes",
    "TorqueTable",
    "TwoMassCheck",
    "Unbalance",
    "Web",
    "analyze_axial",
    "analyze_throw",
    "assemble_dynamic_shaft",
    "axial_formula",
    "axial_formulas",
    "critical_speeds",
    "cylinder_motion",
    "draw_throw",
    "engine_orders",
    "fillet_stresses",
    "find_optimum",
    "gas_forces",
    "harmonics",
    "import_throw",
    "load_crankshaft",
    "load_engine",
    "load_throw",
    "mechanism_forces",
    "mesh_throw",
    "natural_modes",
    "picture_shaft",
    "picture_stresses",
    "picture_throw",
    "read_torque_table",
    "reduced_inertia",
    "run_engine",
    "run_study",
    "shaft_compliances",
    "throw_masses",
    "torsional_formulas",
    "two_mass_check",
    "unbalance",
    "write_calculix",
    "write_mesh",
    "write_step",
]


def __getattr__(name: str) -> Any:
    """Load a public name when it is first used."""
    if name not in _HOMES:
        raise AttributeError(f"module 'crankfem' has no attribute {name!r}")
    value = getattr(import_module(_HOMES[name]), _OTHER_NAMES.get(name, name))
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted({*globals(), *_HOMES})
