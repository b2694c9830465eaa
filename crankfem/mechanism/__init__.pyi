"""Public names of this topic and their homes."""

from dynamics.engine.forces import MechanismForces as MechanismForces
from dynamics.engine.forces import mechanism_forces as mechanism_forces
from dynamics.engine.forces import piston_position as piston_position
from dynamics.engine.layout import RotatingMass as RotatingMass
from dynamics.engine.layout import SlavePin as SlavePin
from dynamics.engine.loads import LoadDiagram as LoadDiagram
from dynamics.engine.loads import crankpin_loads as crankpin_loads
from dynamics.engine.loads import main_bearing_loads as main_bearing_loads
from dynamics.engine.motions import CylinderMotion as CylinderMotion
from dynamics.engine.motions import acceleration_orders as acceleration_orders
from dynamics.engine.motions import cylinder_motion as cylinder_motion
from dynamics.engine.motions import piston_acceleration as piston_acceleration
from dynamics.engine.motions import reduced_inertia as reduced_inertia
from dynamics.engine.rods import RodModel as RodModel
from dynamics.engine.slider_crank import PointMotion as PointMotion
from dynamics.engine.slider_crank import SliderCrank as SliderCrank
from dynamics.engine.slider_crank import TurnMotion as TurnMotion
