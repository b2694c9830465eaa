"""Public names of this topic and their homes."""

from crankfem.analyses.hinge.hinge_run import HingeRun as HingeRun
from crankfem.analyses.hinge.hinge_run import run_hinge as run_hinge
from crankfem.files.hinge.hinge_file import HingeFile as HingeFile
from crankfem.files.hinge.hinge_file import load_hinge as load_hinge
from dynamics.hinge.crosshead import CrossheadEngine as CrossheadEngine
from dynamics.hinge.crosshead import piston_gas_force as piston_gas_force
from dynamics.hinge.crosshead import two_stroke_cycle as two_stroke_cycle
from dynamics.hinge.moment import HingeMoment as HingeMoment
from dynamics.hinge.moment import hinge_moment as hinge_moment
from dynamics.hinge.profile import HingeProfile as HingeProfile
from dynamics.hinge.profile import ProfileCheck as ProfileCheck
from dynamics.hinge.profile import hinge_profile as hinge_profile
from dynamics.hinge.reduced_crank import ReducedCrank as ReducedCrank
from dynamics.hinge.reduced_crank import reduced_crank as reduced_crank
from dynamics.hinge.simulation import SteadyHingeTurn as SteadyHingeTurn
from dynamics.hinge.simulation import simulate_hinge as simulate_hinge
from dynamics.hinge.simulation import steady_hinge_turn as steady_hinge_turn
from dynamics.hinge.speed_smoothing import BestPressure as BestPressure
from dynamics.hinge.speed_smoothing import best_pressure as best_pressure
from dynamics.hinge.speed_smoothing import flywheel_for as flywheel_for
from dynamics.hinge.spring import GasSpring as GasSpring
