"""Public names of this topic and their homes."""

from dynamics.response.complex_modes import ComplexModes as ComplexModes
from dynamics.response.complex_modes import complex_modes as complex_modes
from dynamics.response.damped_criticals import damped_criticals as damped_criticals
from dynamics.response.linear_system import EngineMagnifier as EngineMagnifier
from dynamics.response.loads import ElementLoads as ElementLoads
from dynamics.response.loads import alternating_stress as alternating_stress
from dynamics.response.loads import element_loads as element_loads
from dynamics.response.loads import section_modulus as section_modulus
from dynamics.response.order_excitation import phasors_of as phasors_of
from dynamics.response.peak_cause import PeakCause as PeakCause
from dynamics.response.peak_cause import peak_cause as peak_cause
from dynamics.response.resonance import campbell_diagram as campbell_diagram
from dynamics.response.resonance import refined_speeds as refined_speeds
from dynamics.response.series import OrderSeries as OrderSeries
from dynamics.response.series import Synthesis as Synthesis
