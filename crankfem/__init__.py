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
    from crankfem.hinge_file import HingeFile, load_hinge
    from crankfem.mechanism_file import MechanismFile, load_mechanism, with_throws
    from crankfem.mechanism_run import MechanismRun, run_mechanism
    from crankfem.pictures.balance_plots import plot_accelerations, plot_balance, plot_hinged_rods
    from crankfem.pictures.drawing import draw_throw
    from crankfem.pictures.load_plots import plot_developed_loads, plot_polar_loads
    from crankfem.pictures.solid_picture import picture_shaft, picture_throw
    from crankfem.pictures.stress_picture import picture_stresses
    from crankfem.pipeline import RunResult, run_engine
    from crankfem.studies import StudyResult, run_study
    from dynamics.balance.balance import Balance, OrderBalance, balance
    from dynamics.balance.hinged_rods import HingedRodEffects, hinged_rod_effects, hodograph_change
    from dynamics.balance.hodograph import Hodograph, order_vectors
    from dynamics.balance.moving_masses import MovingMasses, balancing_masses, moving_masses
    from dynamics.chains.chain import Chain
    from dynamics.chains.chain_modes import Modes
    from dynamics.chains.links import Dashpot, Gear
    from dynamics.chains.two_mass import TwoMassCheck, two_mass_check
    from dynamics.critical import CriticalSpeed, critical_speeds, engine_orders
    from dynamics.engine.cylinder import EngineCylinder, RotatingMass, SlavePin
    from dynamics.engine.forces import MechanismForces, mechanism_forces
    from dynamics.engine.gas_forces import gas_forces, piston_position
    from dynamics.engine.layout import EngineLayout
    from dynamics.engine.loads import LoadDiagram, crankpin_loads, main_bearing_loads
    from dynamics.engine.motions import CylinderMotion, cylinder_motion, reduced_inertia
    from dynamics.engine.orders import acceleration_orders, piston_acceleration
    from dynamics.gas.cycle_values import GasCycle, usual_gas_cycle
    from dynamics.gas.gas_cycle import GasCycleResult, gas_cycle
    from dynamics.gas.indicated import indicated_work
    from dynamics.gas.pressure import GasPressure, gas_pressure
    from dynamics.gas.pressure_table import read_pressure_table
    from dynamics.harmonics import Harmonics, harmonics, harmonics_by_sums
    from dynamics.hinge.crosshead import CrossheadEngine
    from dynamics.hinge.evening import BestPressure, best_pressure, flywheel_for
    from dynamics.hinge.gas_force import piston_gas_force, two_stroke_cycle
    from dynamics.hinge.moment import HingeMoment, hinge_moment
    from dynamics.hinge.profile import HingeProfile, ProfileCheck, hinge_profile
    from dynamics.hinge.reduced import ReducedCrank, reduced_crank
    from dynamics.hinge.running import SteadyHingeTurn, simulate_hinge, steady_hinge_turn
    from dynamics.hinge.spring import GasSpring
    from dynamics.mechanism.motion import PointMotion, TurnMotion
    from dynamics.mechanism.rods import ConnectingRod, RodModel
    from dynamics.mechanism.slider_crank import SliderCrank
    from dynamics.torque.pin_harmonics import PinForceHarmonics, pin_force_harmonics
    from dynamics.torque.star import Star, leading_stars, same_stars, star_diagram
    from dynamics.torque.torque import EngineTorque, engine_torque
    from dynamics.torque_table import TorqueTable, read_torque_table
    from dynamics.turning.free_turning import FreeTurning, turn_freely
    from dynamics.turning.speed_over_angle import SpeedOverAngle, speed_over_angle
    from dynamics.turning.steady_engine import turn_steadily
    from dynamics.turning.steady_turning import SteadyTurning, steady_turning
    from fem.analysis import AxialAnalysis, ThrowAnalysis, analyze_axial, analyze_throw
    from fem.angle_law import AngleLaw
    from fem.calculix import write_calculix
    from fem.craig_bampton import DynamicSuperelement, assemble_dynamic_shaft, natural_modes
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
        "crankfem.engine_file": ("EngineFile", "load_crankshaft", "load_engine", "load_throw"),
        "crankfem.hinge_file": ("HingeFile", "load_hinge"),
        "crankfem.mechanism_file": ("MechanismFile", "load_mechanism", "with_throws"),
        "crankfem.mechanism_run": ("MechanismRun", "run_mechanism"),
        "crankfem.pictures.balance_plots": (
            "plot_accelerations",
            "plot_balance",
            "plot_hinged_rods",
        ),
        "crankfem.pictures.drawing": ("draw_throw",),
        "crankfem.pictures.load_plots": ("plot_developed_loads", "plot_polar_loads"),
        "crankfem.pictures.solid_picture": ("picture_shaft", "picture_throw"),
        "crankfem.pictures.stress_picture": ("picture_stresses",),
        "crankfem.pipeline": ("RunResult", "run_engine"),
        "crankfem.studies": ("StudyResult", "run_study"),
        "dynamics.balance.balance": ("Balance", "OrderBalance", "balance"),
        "dynamics.balance.hinged_rods": (
            "HingedRodEffects",
            "hinged_rod_effects",
            "hodograph_change",
        ),
        "dynamics.balance.hodograph": ("Hodograph", "order_vectors"),
        "dynamics.balance.moving_masses": ("MovingMasses", "balancing_masses", "moving_masses"),
        "dynamics.chains.chain": ("Chain",),
        "dynamics.chains.chain_modes": ("Modes",),
        "dynamics.chains.links": ("Dashpot", "Gear"),
        "dynamics.chains.two_mass": ("TwoMassCheck", "two_mass_check"),
        "dynamics.critical": ("CriticalSpeed", "critical_speeds", "engine_orders"),
        "dynamics.engine.cylinder": ("EngineCylinder", "RotatingMass", "SlavePin"),
        "dynamics.engine.forces": ("MechanismForces", "mechanism_forces"),
        "dynamics.engine.gas_forces": ("gas_forces", "piston_position"),
        "dynamics.engine.layout": ("EngineLayout",),
        "dynamics.engine.loads": ("LoadDiagram", "crankpin_loads", "main_bearing_loads"),
        "dynamics.engine.motions": ("CylinderMotion", "cylinder_motion", "reduced_inertia"),
        "dynamics.engine.orders": ("acceleration_orders", "piston_acceleration"),
        "dynamics.gas.cycle_values": ("GasCycle", "usual_gas_cycle"),
        "dynamics.gas.gas_cycle": ("GasCycleResult", "gas_cycle"),
        "dynamics.gas.indicated": ("indicated_work",),
        "dynamics.gas.pressure": ("GasPressure", "gas_pressure"),
        "dynamics.gas.pressure_table": ("read_pressure_table",),
        "dynamics.harmonics": ("Harmonics", "harmonics", "harmonics_by_sums"),
        "dynamics.hinge.crosshead": ("CrossheadEngine",),
        "dynamics.hinge.evening": ("BestPressure", "best_pressure", "flywheel_for"),
        "dynamics.hinge.gas_force": ("piston_gas_force", "two_stroke_cycle"),
        "dynamics.hinge.moment": ("HingeMoment", "hinge_moment"),
        "dynamics.hinge.profile": ("HingeProfile", "ProfileCheck", "hinge_profile"),
        "dynamics.hinge.reduced": ("ReducedCrank", "reduced_crank"),
        "dynamics.hinge.running": ("SteadyHingeTurn", "simulate_hinge", "steady_hinge_turn"),
        "dynamics.hinge.spring": ("GasSpring",),
        "dynamics.mechanism.motion": ("PointMotion", "TurnMotion"),
        "dynamics.mechanism.rods": ("ConnectingRod", "RodModel"),
        "dynamics.mechanism.slider_crank": ("SliderCrank",),
        "dynamics.torque.pin_harmonics": ("PinForceHarmonics", "pin_force_harmonics"),
        "dynamics.torque.star": ("Star", "leading_stars", "same_stars", "star_diagram"),
        "dynamics.torque.torque": ("EngineTorque", "engine_torque"),
        "dynamics.torque_table": ("TorqueTable", "read_torque_table"),
        "dynamics.turning.free_turning": ("FreeTurning", "turn_freely"),
        "dynamics.turning.speed_over_angle": ("SpeedOverAngle", "speed_over_angle"),
        "dynamics.turning.steady_engine": ("turn_steadily",),
        "dynamics.turning.steady_turning": ("SteadyTurning", "steady_turning"),
        "fem.analysis": ("AxialAnalysis", "ThrowAnalysis", "analyze_axial", "analyze_throw"),
        "fem.angle_law": ("AngleLaw",),
        "fem.calculix": ("write_calculix",),
        "fem.craig_bampton": ("DynamicSuperelement", "assemble_dynamic_shaft", "natural_modes"),
        "fem.fillet_stress": ("FilletPeak", "FilletStresses", "fillet_stresses"),
        "fem.material": ("Material", "STEEL"),
        "fem.modes": ("ThrowModes",),
        "fem.pin_response": ("Motion", "PinResponse"),
        "fem.shaft": ("ShaftCompliances", "shaft_compliances"),
        "fem.solver": ("SolveError",),
        "fem.supports": ("EndReaction", "Neighbors", "Reactions"),
        "geometry.balance": ("Unbalance", "unbalance"),
        "geometry.crankshaft": ("Crankshaft", "throw_masses"),
        "geometry.errors": ("InputError", "MeshError", "MissingLibraryError"),
        "geometry.imported": ("ImportedThrow", "import_throw"),
        "geometry.mass": ("MassProperties",),
        "geometry.mesh": ("ThrowMesh",),
        "geometry.mesh_files": ("write_mesh",),
        "geometry.mesher": ("mesh_throw",),
        "geometry.shaft_ends": ("ShaftEnds",),
        "geometry.solid_files": ("write_step",),
        "geometry.throw": ("CrankThrow",),
        "geometry.throw_sections": ("Counterweight", "FurtherPin", "Web"),
        "regression.formulas.axial_formulas": ("axial_formula", "axial_formulas"),
        "regression.formulas.formula_value": ("FormulaValue",),
        "regression.formulas.torsional_formulas": ("torsional_formulas",),
        "regression.models.compliance_model": ("ComplianceModel", "Lookup", "OutsideRangeWarning"),
        "regression.models.optimum": ("Optimum", "find_optimum"),
        "regression.models.optimum_limits": ("Limit",),
    }.items()
    for name in names
}

# Public names that are not those at home: users mesh in a process of its own.
_OTHER_NAMES = {"mesh_throw": "mesh_isolated"}

__all__ = [
    "STEEL",
    "AngleLaw",
    "AxialAnalysis",
    "Balance",
    "BestPressure",
    "Chain",
    "ComplianceModel",
    "ConnectingRod",
    "Counterweight",
    "CrankThrow",
    "Crankshaft",
    "CriticalSpeed",
    "CrossheadEngine",
    "CylinderMotion",
    "Dashpot",
    "DynamicSuperelement",
    "EndReaction",
    "EngineCylinder",
    "EngineFile",
    "EngineLayout",
    "EngineTorque",
    "FilletPeak",
    "FilletStresses",
    "FormulaValue",
    "FreeTurning",
    "FurtherPin",
    "GasCycle",
    "GasCycleResult",
    "GasPressure",
    "GasSpring",
    "Gear",
    "Harmonics",
    "HingeFile",
    "HingeMoment",
    "HingeProfile",
    "HingedRodEffects",
    "Hodograph",
    "ImportedThrow",
    "InputError",
    "Limit",
    "LoadDiagram",
    "Lookup",
    "MassProperties",
    "Material",
    "MechanismFile",
    "MechanismForces",
    "MechanismRun",
    "MeshError",
    "MissingLibraryError",
    "Modes",
    "Motion",
    "MovingMasses",
    "Neighbors",
    "Optimum",
    "OrderBalance",
    "OutsideRangeWarning",
    "PinForceHarmonics",
    "PinResponse",
    "PointMotion",
    "ProfileCheck",
    "Reactions",
    "ReducedCrank",
    "RodModel",
    "RotatingMass",
    "RunResult",
    "ShaftCompliances",
    "ShaftEnds",
    "SlavePin",
    "SliderCrank",
    "SolveError",
    "SpeedOverAngle",
    "Star",
    "SteadyHingeTurn",
    "SteadyTurning",
    "StudyResult",
    "ThrowAnalysis",
    "ThrowMesh",
    "ThrowModes",
    "TorqueTable",
    "TurnMotion",
    "TwoMassCheck",
    "Unbalance",
    "Web",
    "acceleration_orders",
    "analyze_axial",
    "analyze_throw",
    "assemble_dynamic_shaft",
    "axial_formula",
    "axial_formulas",
    "balance",
    "balancing_masses",
    "best_pressure",
    "crankpin_loads",
    "critical_speeds",
    "cylinder_motion",
    "draw_throw",
    "engine_orders",
    "engine_torque",
    "fillet_stresses",
    "find_optimum",
    "flywheel_for",
    "gas_cycle",
    "gas_forces",
    "gas_pressure",
    "harmonics",
    "harmonics_by_sums",
    "hinge_moment",
    "hinge_profile",
    "hinged_rod_effects",
    "hodograph_change",
    "import_throw",
    "indicated_work",
    "leading_stars",
    "load_crankshaft",
    "load_engine",
    "load_hinge",
    "load_mechanism",
    "load_throw",
    "main_bearing_loads",
    "mechanism_forces",
    "mesh_throw",
    "moving_masses",
    "natural_modes",
    "order_vectors",
    "picture_shaft",
    "picture_stresses",
    "picture_throw",
    "pin_force_harmonics",
    "piston_acceleration",
    "piston_gas_force",
    "piston_position",
    "plot_accelerations",
    "plot_balance",
    "plot_developed_loads",
    "plot_hinged_rods",
    "plot_polar_loads",
    "read_pressure_table",
    "read_torque_table",
    "reduced_crank",
    "reduced_inertia",
    "run_engine",
    "run_mechanism",
    "run_study",
    "same_stars",
    "shaft_compliances",
    "simulate_hinge",
    "speed_over_angle",
    "star_diagram",
    "steady_hinge_turn",
    "steady_turning",
    "throw_masses",
    "torsional_formulas",
    "turn_freely",
    "turn_steadily",
    "two_mass_check",
    "two_stroke_cycle",
    "unbalance",
    "usual_gas_cycle",
    "with_throws",
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
