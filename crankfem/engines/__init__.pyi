"""Public names of this topic and their homes."""

from crankfem.analyses.assumptions import assumed_values as assumed_values
from crankfem.analyses.engine_mechanism import input_warnings as input_warnings
from crankfem.analyses.vibration.assessment import Assessment as Assessment
from crankfem.analyses.vibration.assessment import Uncertainty as Uncertainty
from crankfem.analyses.vibration.forced import ForcedVibration as ForcedVibration
from crankfem.analyses.vibration.modes import Vibration as Vibration
