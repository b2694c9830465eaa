"""Public names of this topic and their homes."""

from crankfem.satellites.hinge.crosshead import CrossheadEngine as CrossheadEngine
from crankfem.satellites.hinge.crosshead import piston_gas_force as piston_gas_force
from crankfem.satellites.hinge.crosshead import two_stroke_cycle as two_stroke_cycle
from crankfem.satellites.hinge.file import load_hinge as load_hinge
from crankfem.satellites.hinge.moment import HingeMoment as HingeMoment
from crankfem.satellites.hinge.moment import hinge_moment as hinge_moment
from crankfem.satellites.hinge.profile import HingeProfile as HingeProfile
from crankfem.satellites.hinge.profile import hinge_profile as hinge_profile
from crankfem.satellites.hinge.run import HingeRun as HingeRun
from crankfem.satellites.hinge.run import run_hinge as run_hinge
from crankfem.satellites.hinge.spring import GasSpring as GasSpring
from crankfem.satellites.hinge.turning import SteadyHingeTurn as SteadyHingeTurn
from crankfem.satellites.hinge.turning import best_pressure as best_pressure
from crankfem.satellites.hinge.turning import flywheel_for as flywheel_for
from crankfem.satellites.hinge.turning import simulate_hinge as simulate_hinge
from crankfem.satellites.hinge.turning import steady_hinge_turn as steady_hinge_turn
