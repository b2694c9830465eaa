"""Public names of this topic and their homes."""

from dynamics.torque import PinForceHarmonics as PinForceHarmonics
from dynamics.torque import Star as Star
from dynamics.torque import leading_stars as leading_stars
from dynamics.torque import pin_force_harmonics as pin_force_harmonics
from dynamics.torque import same_stars as same_stars
from dynamics.torque import star_diagram as star_diagram
from dynamics.turning.free_turning import FreeTurning as FreeTurning
from dynamics.turning.free_turning import turn_freely as turn_freely
from dynamics.turning.free_turning import turn_steadily as turn_steadily
from dynamics.turning.speed_over_angle import SpeedOverAngle as SpeedOverAngle
from dynamics.turning.speed_over_angle import speed_over_angle as speed_over_angle
from dynamics.turning.speed_over_angle import steady_turning as steady_turning
