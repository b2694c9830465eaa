"""Public names of this topic and their homes."""

from fem.analysis import AxialAnalysis as AxialAnalysis
from fem.analysis import analyze_axial as analyze_axial
from fem.angle_law import AngleLaw as AngleLaw
from fem.calculix import write_calculix as write_calculix
from fem.end_reactions import EndReaction as EndReaction
from fem.end_reactions import Reactions as Reactions
from fem.fillet_peaks import FilletPeak as FilletPeak
from fem.fillet_peaks import FilletStresses as FilletStresses
from fem.fillet_peaks import OilHolePeak as OilHolePeak
from fem.fillet_stress import fillet_stresses as fillet_stresses
from fem.modes import DynamicSuperelement as DynamicSuperelement
from fem.modes import ThrowModes as ThrowModes
from fem.sensitivities import Sensitivities as Sensitivities
from fem.superelement import ShaftCompliances as ShaftCompliances
from fem.superelement import shaft_compliances as shaft_compliances
from fem.supports import Motion as Motion
from fem.supports import PinResponse as PinResponse
