"""Public names of this topic and their homes."""

from dynamics.engine.forces import LoadDiagram as LoadDiagram
from dynamics.engine.forces import MechanismForces as MechanismForces
from dynamics.engine.forces import acceleration_orders as acceleration_orders
from dynamics.engine.forces import crankpin_loads as crankpin_loads
from dynamics.engine.forces import cylinder_motion as cylinder_motion
from dynamics.engine.forces import main_bearing_loads as main_bearing_loads
from dynamics.engine.forces import mechanism_forces as mechanism_forces
from dynamics.engine.forces import piston_acceleration as piston_acceleration
from dynamics.engine.forces import piston_position as piston_position
from dynamics.engine.forces import reduced_inertia as reduced_inertia
from dynamics.engine.layout import RotatingMass as RotatingMass
from dynamics.engine.layout import SlavePin as SlavePin
from dynamics.engine.rods import RodModel as RodModel
from dynamics.engine.rods import SliderCrank as SliderCrank
