import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from comparing import close
from fem.superelement import RZ, UZ, assemble_shaft, shaft_compliances
from fem.supports import support_throw
from geometry.mesh import mesh_throw
from geometry.throw import CrankThrow
from refusals import refused

UNEVEN = np.radians([0.0, 75.0, 200.0, 250.0, 10.0])
UNEVEN_DEG = np.degrees(UNEVEN)


@pytest.fixture(scope="module")
def uneven_shaft(superelement, dimensions, condensed):
    """Throws of two kinds, one with thicker webs and a longer pin."""
    other = CrankThrow(**{**dimensions, "web_thickness": 0.090, "pin_length": 0.170})
    _, second = condensed(mesh_throw(other, 3.0))
    return [superelement, second, superelement, superelement, second]


def test_opposite_cranks_are_pinned_under_axial_force(superelement):
    found = shaft_compliances([superelement] * 4, crank_angles_deg=[0.0, 180.0, 0.0, 180.0])
    assert found.axial == close(support_throw(superelement, "pinned").axial, rel=1e-8)


def test_inner_throws_in_line_near_guided(superelement):
    found = shaft_compliances([superelement] * 9, crank_angles_deg=[0.0] * 9)
    guided, pinned = (support_throw(superelement, name) for name in ("guided", "pinned"))
    assert found.axial[4] == close(guided.axial, rel=0.02)
    assert found.torsional == close(pinned.torsional, rel=1e-8)


def test_influences_of_equal_throws_are_symmetric(superelement):
    """An axial force and a radial pin force tilt equal ends in the same ratio, at any crank angles."""
    influence = shaft_compliances([superelement] * 5, crank_angles_deg=UNEVEN_DEG).influence
    assert influence == close(influence.T, abs=1e-9 * np.abs(influence).max())
    assert (np.diag(influence) > 0.0).all()


@pytest.mark.parametrize("throws", [0, 2])
def test_as_many_angles_as_throws(superelement, throws):
    with refused("crank_angles_deg"):
        shaft_compliances([superelement] * throws, crank_angles_deg=[0.0])


def test_soft_bearings_tend_to_none_and_stiff_ones_to_rigid(uneven_shaft):
    rigid = shaft_compliances(uneven_shaft, crank_angles_deg=UNEVEN_DEG)
    for stiffness, limit in ((1e2, 0.0), (1e15, np.inf)):
        near = shaft_compliances(
            uneven_shaft, crank_angles_deg=UNEVEN_DEG, bearing_stiffness=stiffness
        )
        wanted = shaft_compliances(
            uneven_shaft, crank_angles_deg=UNEVEN_DEG, bearing_stiffness=limit
        )
        for name in ("axial", "torsional", "influence", "tangential", "through"):
            size = np.abs(
                getattr(rigid, name)
            ).max()  # no torque lengthens a shaft in free journals
            assert getattr(near, name) == close(getattr(wanted, name), abs=1e-4 * size)


@settings(max_examples=15, deadline=None)
@given(exponents=st.lists(st.floats(6.0, 12.0), min_size=6, max_size=6))
def test_compliances_on_elastic_bearings_are_those_of_the_assembled_shaft(uneven_shaft, exponents):
    """Each bearing another: the sums of stretch and twist against the inverse of the whole stiffness."""
    bearings = 10.0 ** np.array(exponents)
    found = shaft_compliances(uneven_shaft, crank_angles_deg=UNEVEN_DEG, bearing_stiffness=bearings)
    turned = [
        part.turned(angle_deg=np.degrees(angle))
        for part, angle in zip(uneven_shaft, UNEVEN, strict=True)
    ]
    stiffness = assemble_shaft(turned)
    springs = np.zeros((6, 6))
    springs[:, :2] = bearings[:, None]
    stiffness += np.diag(springs.ravel())
    free = np.setdiff1d(np.arange(36), [UZ, RZ])
    flexibility = np.linalg.inv(stiffness[np.ix_(free, free)])
    last = [int(np.flatnonzero(free == 30 + unknown)[0]) for unknown in (UZ, RZ)]
    assert found.axial.sum() == close(flexibility[last[0], last[0]], rel=1e-9)
    assert found.torsional.sum() == close(flexibility[last[1], last[1]], rel=1e-9)
    assert found.through.sum() == close(flexibility[last[0], last[1]], abs=1e-9 * found.axial.sum())


@pytest.mark.parametrize("bearings", [-1.0, np.nan, [1e9] * 2, [0.0, 0.0, 1e9], [1e9, np.nan, 1e9]])
def test_bearings_that_cannot_be(superelement, bearings):
    with refused("bearing_stiffness"):
        shaft_compliances(
            [superelement] * 2, crank_angles_deg=[0.0, 60.0], bearing_stiffness=bearings
        )


def test_crank_angles_are_degrees_told_by_name(superelement):
    """480 deg is 120 deg and -120 deg is 240 deg; the like in radians is not."""
    found = shaft_compliances([superelement] * 3, crank_angles_deg=[0, 120, 240])
    turned = shaft_compliances([superelement] * 3, crank_angles_deg=[0, 480, -120])
    assert found.axial == close(turned.axial)
    with pytest.raises(TypeError):
        shaft_compliances([superelement] * 3, [0, 120, 240])
