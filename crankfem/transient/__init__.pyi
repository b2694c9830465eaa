"""Public names of this topic and their homes."""

from crankfem.analyses.vibration.run_up import RunUp as RunUp
from crankfem.analyses.vibration.run_up import run_up as run_up
from dynamics.transient.applied_forces import LoadStep as LoadStep
from dynamics.transient.applied_forces import SpeedCurve as SpeedCurve
from dynamics.transient.motions import Envelope as Envelope
from dynamics.transient.propagator import ViscousSystem as ViscousSystem
from dynamics.transient.propagator import viscous_system as viscous_system
from dynamics.transient.run import SteadyMotion as SteadyMotion
from dynamics.transient.run import TransientMotion as TransientMotion
from dynamics.transient.run import steady_motion as steady_motion
from dynamics.transient.run import transient_motion as transient_motion
from dynamics.transient.turning_chain import TurningChain as TurningChain
from dynamics.transient.turning_chain import turning_chain as turning_chain
from dynamics.transient.turning_run import TurningCycle as TurningCycle
from dynamics.transient.turning_run import TurningRun as TurningRun
from dynamics.transient.turning_run import steady_cycle as steady_cycle
from dynamics.transient.turning_run import turn_under_gas as turn_under_gas
