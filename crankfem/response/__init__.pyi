"""Public names of this topic and their homes."""

from dynamics.response.campbell_diagram import campbell_diagram as campbell_diagram
from dynamics.response.damping import DampedChain as DampedChain
from dynamics.response.damping import EngineMagnifier as EngineMagnifier
from dynamics.response.linear_system import LinearSystem as LinearSystem
from dynamics.response.loads import ElementLoads as ElementLoads
from dynamics.response.loads import alternating_stress as alternating_stress
from dynamics.response.loads import element_loads as element_loads
from dynamics.response.loads import section_modulus as section_modulus
from dynamics.response.order_excitation import phasors_of as phasors_of
from dynamics.response.series import OrderSeries as OrderSeries
from dynamics.response.speed_grid import refined_speeds as refined_speeds
from dynamics.response.synthesis import Synthesis as Synthesis
