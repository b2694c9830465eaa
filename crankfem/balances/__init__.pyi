"""Public names of this topic and their homes."""

from dynamics.balance import HingedRodEffects as HingedRodEffects
from dynamics.balance import Hodograph as Hodograph
from dynamics.balance import balancing_masses as balancing_masses
from dynamics.balance import hinged_rod_effects as hinged_rod_effects
from dynamics.balance import hodograph_change as hodograph_change
from dynamics.balance import moving_masses as moving_masses
from dynamics.balance import order_vectors as order_vectors
