"""Public names of this topic and their homes."""

from crankfem.analyses.vibration.misfiring import Misfiring as Misfiring
from dynamics.assessment.barred_ranges import BarredRangeRule as BarredRangeRule
from dynamics.assessment.limit_rules import crankshaft_limit as crankshaft_limit
from dynamics.assessment.limit_rules import generator_set_limit as generator_set_limit
from dynamics.assessment.limit_rules import propulsion_shaft_limit as propulsion_shaft_limit
from dynamics.assessment.limits import AmplitudeCurve as AmplitudeCurve
from dynamics.assessment.limits import LimitCurve as LimitCurve
from dynamics.assessment.limits import VibrationLimit as VibrationLimit
from dynamics.assessment.limits import axial_force_limit as axial_force_limit
from dynamics.assessment.limits import given_limit as given_limit
from dynamics.assessment.response_curves import curves_of as curves_of
from dynamics.assessment.response_curves import element_load as element_load
from dynamics.assessment.response_curves import node_amplitude as node_amplitude
from dynamics.assessment.separation import critical_ranges as critical_ranges
from dynamics.assessment.uncertainty import Samples as Samples
from dynamics.assessment.uncertainty import Spread as Spread
from dynamics.assessment.uncertainty import chain_samples as chain_samples
from dynamics.assessment.uncertainty import frequency_bounds as frequency_bounds
from dynamics.assessment.uncertainty import frequency_samples as frequency_samples
from dynamics.assessment.uncertainty import frequency_sensitivities as frequency_sensitivities
from dynamics.assessment.verdict import Decision as Decision
from dynamics.assessment.verdict import LimitCheck as LimitCheck
from dynamics.assessment.verdict import decide as decide
