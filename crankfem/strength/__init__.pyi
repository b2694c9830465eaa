"""Public names of this topic and their homes."""

from crankfem.analyses.strength.engine_strength import EngineStrength as EngineStrength
from crankfem.analyses.strength.engine_strength import ThrowStrength as ThrowStrength
from crankfem.analyses.strength.engine_strength import engine_strength as engine_strength
from crankfem.analyses.strength.shaft_loads import LargestLoad as LargestLoad
from crankfem.analyses.strength.supported_throws import supported_throws as supported_throws
from dynamics.strength.concentration import ConcentrationFactors as ConcentrationFactors
from dynamics.strength.concentration import coefficient_differences as coefficient_differences
from dynamics.strength.crank_web import CrankWeb as CrankWeb
from dynamics.strength.fatigue import PlaceStrength as PlaceStrength
from dynamics.strength.fatigue import added_bending as added_bending
from dynamics.strength.fatigue import fatigue_strength as fatigue_strength
from dynamics.strength.fatigue import fillet_equivalent as fillet_equivalent
from dynamics.strength.fatigue import hole_equivalent as hole_equivalent
from dynamics.strength.nominal import SupportedThrow as SupportedThrow
from dynamics.strength.nominal import alternating as alternating
from dynamics.strength.nominal import hole_stress as hole_stress
from dynamics.strength.nominal import web_stresses as web_stresses
from dynamics.strength.shrink_fit import ShrinkFit as ShrinkFit
from dynamics.strength.surface_treatment import SurfaceTreatment as SurfaceTreatment
from dynamics.strength.surface_treatment import factors_below as factors_below
from dynamics.strength.surface_treatment import strength_near_end as strength_near_end
