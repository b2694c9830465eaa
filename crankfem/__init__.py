"""crankfem: axial and torsional vibration of crankshafts, from crank-throw dimensions to a verdict.

Everything a user needs has a name here; the packages behind it are internal. Names are loaded when
first used, so that looking a compliance up does not load a mesher.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

from crankfem._packages import check_packages

check_packages()

if TYPE_CHECKING:
    from crankfem.engine_file import EngineFile, load_engine
    from crankfem.pipeline import RunResult, run_engine
    from crankfem.studies import StudyResult, run_study
    from dynamics.chain import Chain, Modes
    from dynamics.critical import CriticalSpeed, critical_speeds, engine_orders
    from dynamics.harmonics import Harmonics, harmonics
    from dynamics.torque_table import TorqueTable, read_torque_table
    from dynamics.two_mass import TwoMassCheck, two_mass_check
    from fem.analysis import ThrowAnalysis, analyze_throw
    from fem.material import STEEL, Material
    from fem.shaft import ShaftCompliances, shaft_compliances
    from fem.solver import SolveError
    from fem.supports import EndReaction, Neighbors, Reactions
    from geometry.errors import InputError, MeshError, MissingLibraryError
    from geometry.throw import CrankThrow
    from regression.axial_formulas import axial_formula, axial_formulas
    from regression.compliance_model import ComplianceModel, Lookup, OutsideRangeWarning
    from regression.formula_value import FormulaValue
    from regression.torsional_formulas import torsional_formulas

_HOMES = {
    "STEEL": "fem.material",
    "Chain": "dynamics.chain",
    "ComplianceModel": "regression.compliance_model",
    "CrankThrow": "geometry.throw",
    "CriticalSpeed": "dynamics.critical",
    "EndReaction": "fem.supports",
    "EngineFile": "crankfem.engine_file",
    "FormulaValue": "regression.formula_value",
    "Harmonics": "dynamics.harmonics",
    "InputError": "geometry.errors",
    "Lookup": "regression.compliance_model",
    "Material": "fem.material",
    "MeshError": "geometry.errors",
    "MissingLibraryError": "geometry.errors",
    "Modes": "dynamics.chain",
    "Neighbors": "fem.supports",
    "OutsideRangeWarning": "regression.compliance_model",
    "Reactions": "fem.supports",
    "RunResult": "crankfem.pipeline",
    "ShaftCompliances": "fem.shaft",
    "SolveError": "fem.solver",
    "StudyResult": "crankfem.studies",
    "ThrowAnalysis": "fem.analysis",
    "TorqueTable": "dynamics.torque_table",
    "TwoMassCheck": "dynamics.two_mass",
    "analyze_throw": "fem.analysis",
    "axial_formula": "regression.axial_formulas",
    "axial_formulas": "regression.axial_formulas",
    "critical_speeds": "dynamics.critical",
    "engine_orders": "dynamics.critical",
    "harmonics": "dynamics.harmonics",
    "load_engine": "crankfem.engine_file",
    "read_torque_table": "dynamics.torque_table",
    "run_engine": "crankfem.pipeline",
    "run_study": "crankfem.studies",
    "shaft_compliances": "fem.shaft",
    "torsional_formulas": "regression.torsional_formulas",
    "two_mass_check": "dynamics.two_mass",
}

__all__ = [  # noqa: RUF022  (sorted as in _HOMES, which a test compares)
    *_HOMES
]


def __getattr__(name: str) -> Any:
    """Load a public name when it is first used."""
    if name not in _HOMES:
        raise AttributeError(f"module 'crankfem' has no attribute {name!r}")
    value = getattr(import_module(_HOMES[name]), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted({*globals(), *_HOMES})
