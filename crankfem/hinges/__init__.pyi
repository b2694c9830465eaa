"""Public names of this topic and their homes."""

from crankfem.analyses.hinge.hinge_run import HingeRun as HingeRun
from crankfem.analyses.hinge.hinge_run import run_hinge as run_hinge
from crankfem.files.hinge_file import HingeFile as HingeFile
from crankfem.files.hinge_file import load_hinge as load_hinge
from dynamics.hinge.crosshead import CrossheadEngine as CrossheadEngine
from dynamics.hinge.crosshead import ReducedCrank as ReducedCrank
from dynamics.hinge.crosshead import piston_gas_force as piston_gas_force
from dynamics.hinge.crosshead import reduced_crank as reduced_crank
from dynamics.hinge.crosshead import two_stroke_cycle as two_stroke_cycle
from dynamics.hinge.profile import BestPressure as BestPressure
from dynamics.hinge.profile import GasSpring as GasSpring
from dynamics.hinge.profile import HingeMoment as HingeMoment
from dynamics.hinge.profile import HingeProfile as HingeProfile
from dynamics.hinge.profile import ProfileCheck as ProfileCheck
from dynamics.hinge.profile import SteadyHingeTurn as SteadyHingeTurn
from dynamics.hinge.profile import best_pressure as best_pressure
from dynamics.hinge.profile import flywheel_for as flywheel_for
from dynamics.hinge.profile import hinge_moment as hinge_moment
from dynamics.hinge.profile import hinge_profile as hinge_profile
from dynamics.hinge.profile import simulate_hinge as simulate_hinge
from dynamics.hinge.profile import steady_hinge_turn as steady_hinge_turn
