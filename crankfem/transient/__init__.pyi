"""Public names of this topic and their homes."""

from crankfem.analyses.vibration.run_up import RunUp as RunUp
from crankfem.analyses.vibration.run_up import run_up as run_up
from dynamics.transient.motions import Envelope as Envelope
from dynamics.transient.motions import SteadyMotion as SteadyMotion
from dynamics.transient.motions import TransientMotion as TransientMotion
from dynamics.transient.motions import steady_motion as steady_motion
from dynamics.transient.motions import transient_motion as transient_motion
from dynamics.transient.propagator import LoadStep as LoadStep
from dynamics.transient.propagator import SpeedCurve as SpeedCurve
from dynamics.transient.propagator import viscous_system as viscous_system
from dynamics.transient.turning_run import TurningCycle as TurningCycle
from dynamics.transient.turning_run import TurningRun as TurningRun
from dynamics.transient.turning_run import steady_cycle as steady_cycle
from dynamics.transient.turning_run import turn_under_gas as turn_under_gas
from dynamics.transient.turning_run import turning_chain as turning_chain
