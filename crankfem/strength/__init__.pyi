"""Public names of this topic and their homes."""

from crankfem.analyses.strength.cycle_fatigue import EngineFatigue as EngineFatigue
from crankfem.analyses.strength.cycle_fatigue import engine_fatigue as engine_fatigue
from crankfem.analyses.strength.cycle_loads import supported_throws as supported_throws
from crankfem.analyses.strength.engine_strength import EngineStrength as EngineStrength
from crankfem.analyses.strength.engine_strength import engine_strength as engine_strength
from crankfem.analyses.strength.engine_strength import engine_stresses as engine_stresses
from dynamics.strength.concentration import ConcentrationFactors as ConcentrationFactors
from dynamics.strength.concentration import CrankWeb as CrankWeb
from dynamics.strength.concentration import alternating as alternating
from dynamics.strength.concentration import hole_stress as hole_stress
from dynamics.strength.concentration import web_stresses as web_stresses
from dynamics.strength.fatigue import SurfaceTreatment as SurfaceTreatment
from dynamics.strength.fatigue import added_bending as added_bending
from dynamics.strength.fatigue import critical_plane as critical_plane
from dynamics.strength.fatigue import fatigue_strength as fatigue_strength
from dynamics.strength.fatigue import fillet_equivalent as fillet_equivalent
from dynamics.strength.fatigue import findley_factor as findley_factor
from dynamics.strength.fatigue import findley_limit as findley_limit
from dynamics.strength.fatigue import hole_equivalent as hole_equivalent
from dynamics.strength.shrink_fit import ShrinkFit as ShrinkFit
