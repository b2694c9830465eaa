"""Public names of this topic and their homes."""

from dynamics.balance.balance import HingedRodEffects as HingedRodEffects
from dynamics.balance.balance import OrderBalance as OrderBalance
from dynamics.balance.balance import hinged_rod_effects as hinged_rod_effects
from dynamics.balance.balance import hodograph_change as hodograph_change
from dynamics.balance.moving_masses import Hodograph as Hodograph
from dynamics.balance.moving_masses import MovingMasses as MovingMasses
from dynamics.balance.moving_masses import balancing_masses as balancing_masses
from dynamics.balance.moving_masses import moving_masses as moving_masses
from dynamics.balance.moving_masses import order_vectors as order_vectors
