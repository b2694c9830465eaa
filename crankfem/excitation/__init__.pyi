"""Public names of this topic and their homes."""

from dynamics.excitation.chain_excitation import AxialForceComparison as AxialForceComparison
from dynamics.excitation.chain_excitation import AxialForceOverCycle as AxialForceOverCycle
from dynamics.excitation.chain_excitation import axial_excitation as axial_excitation
from dynamics.excitation.chain_excitation import (
    axial_excitation_of_torsion as axial_excitation_of_torsion,
)
from dynamics.excitation.chain_excitation import axial_force_over_cycle as axial_force_over_cycle
from dynamics.excitation.chain_excitation import combined_excitation as combined_excitation
from dynamics.excitation.chain_excitation import compare_axial_forces as compare_axial_forces
from dynamics.excitation.chain_excitation import node_torques as node_torques
from dynamics.excitation.chain_excitation import (
    tangential_towards_flywheel as tangential_towards_flywheel,
)
from dynamics.excitation.chain_excitation import torque_excitation as torque_excitation
from dynamics.excitation.chain_excitation import torsion_influence as torsion_influence
from dynamics.excitation.cylinders import CylinderForces as CylinderForces
from dynamics.excitation.cylinders import cylinder_forces as cylinder_forces
from dynamics.excitation.cylinders import cylinder_harmonics as cylinder_harmonics
from dynamics.excitation.cylinders import forces_at_speeds as forces_at_speeds
from dynamics.excitation.cylinders import torque_harmonics as torque_harmonics
from dynamics.excitation.pressure_map import PressureMap as PressureMap
from dynamics.excitation.pressure_map import pressure_map as pressure_map
from dynamics.excitation.pressure_map import pressure_map_from_cycles as pressure_map_from_cycles
from dynamics.excitation.pressure_map import propeller_load as propeller_load
from dynamics.excitation.propeller import PropellerForces as PropellerForces
from dynamics.excitation.propeller import propeller_excitation as propeller_excitation
from dynamics.gas.pressure import motored_from_compression as motored_from_compression
