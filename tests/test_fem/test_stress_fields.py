"""Fields of stress of a throw: unit loads by themselves, equilibrium, rigid motions."""

import numpy as np
import pytest

from comparing import close
from crankbase.errors import InputError
from fem.fields import stress_fields
from fem.fillet_peaks import fillet_surface
from fem.loads import radial_directions
from fem.material import STEEL
from fem.supports import TWIST, reactions
from fem.surface_stress import throw_fillets, von_mises
from fem.unit_loads import solve_unit_loads, unit_loads

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def fields(mesh, throw):
    return stress_fields(mesh, throw, STEEL)


@pytest.fixture(scope="module")
def alone(mesh, throw):
    """Stresses under unit loads, by their own solution, ends pinned."""
    return fillet_surface(solve_unit_loads(mesh, unit_loads(radial_directions(throw)), STEEL))


def local_von_mises(stress):
    first, second, between = np.moveaxis(stress, -1, 0)
    return np.sqrt(first**2 - first * second + second**2 + 3.0 * between**2)


def test_unit_loads_have_their_own_stresses(fields, alone, throw):
    """Axial force, torque, both bendings, and the radial force on its two bearings."""
    pin = np.array([0.0, -1.0, 0.0, 0.0, 0.0, 0.0])
    for column, load in enumerate(unit_loads(radial_directions(throw))):
        acting, ends = (0.0 * pin, load.ends) if load.pin is None else (pin, load.ends.copy())
        if load.pin is not None:
            ends[[1, 7]] = 0.5  # bearings press against the force towards the shaft
        amplitudes = fields.amplitudes(ends, acting)
        for fillet, site in zip(throw_fillets(throw.parts), fields.sites, strict=True):
            expected = von_mises(alone.stress[fillet.holds(alone.points), column])
            found = local_von_mises(np.tensordot(amplitudes, site.stress, axes=(0, 1)))
            assert site.name == fillet.name
            assert found == close(expected, abs=1e-6 * expected.max())


def test_a_tangential_force_is_carried_wherever_it_is_held(fields, throw):
    """Torque taken at the left or at the right end: the difference is a torque through the throw."""
    force = np.array([-1.0, 0.0, 0.0, 0.0, 0.0, 0.0])
    held = reactions(fields.superelement, "pinned", fields.superelement.pin_loads[0] @ force)
    left = np.concatenate([held.left.force, held.left.moment, held.right.force, held.right.moment])
    assert left[5] == close(-throw.crank_radius)
    right = left.copy()
    right[[5, 11]] = 0.0, left[5]
    one, other = fields.amplitudes(left, force), fields.amplitudes(right, force)
    through = fields.amplitudes(left[5] * TWIST, np.zeros(6))
    assert other - one == close(through, abs=1e-9 * np.abs(other).max())


def test_loads_out_of_balance_are_refused(fields):
    ends = np.zeros(12)
    ends[1] = 1.0
    with pytest.raises(InputError, match="loads: given ones out of balance"):
        fields.amplitudes(ends, np.zeros(6))


def test_strain_energy_is_that_of_the_amplitudes(fields):
    """End loads in balance do the work c^2 / 2 on the motions that they make."""
    rng = np.random.default_rng(3)
    motions = rng.normal(size=12)
    ends = fields.superelement.stiffness @ motions
    amplitudes = fields.amplitudes(ends, np.zeros(6))
    assert amplitudes[:6] @ amplitudes[:6] == close(motions @ ends)


def test_throws_of_several_pins_are_refused(mesh, throw):
    several = throw.changed(further_pins=({"angle": 1.0, "web_thickness": 0.06},))
    with pytest.raises(InputError, match="throw: given one with 2 pins"):
        stress_fields(mesh, several, STEEL)
