"""Public names of this topic and their homes."""

from dynamics.assessment.damper_sizing import SizedDamper as SizedDamper
from dynamics.assessment.damper_sizing import size_axial_damper as size_axial_damper
from dynamics.assessment.damper_sizing import size_rubber_damper as size_rubber_damper
from dynamics.assessment.damper_sizing import size_viscous_damper as size_viscous_damper
from dynamics.chains.dampers import AxialDamper as AxialDamper
from dynamics.chains.dampers import RubberDamper as RubberDamper
from dynamics.chains.dampers import ViscousDamper as ViscousDamper
from dynamics.chains.dampers import main_inertia as main_inertia
from dynamics.chains.dampers import rubber_damper_for as rubber_damper_for
from dynamics.chains.dampers import rubber_optimum as rubber_optimum
from dynamics.chains.dampers import tuned_optimum as tuned_optimum
from dynamics.chains.dampers import untuned_optimum as untuned_optimum
from dynamics.chains.dampers import viscous_damper_for as viscous_damper_for
