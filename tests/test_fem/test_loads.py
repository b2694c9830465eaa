"""Distributed loads against their resultants, which are exact, and the laws that they are spread by.

Resultants are integrals over the meshed surface with one quadrature, and come out to round-off. The laws
are of a cylinder; the mesh's pin is one to 0.1 % (a quarter turn in two or three curved facets), and
products of loads with functions of third order add the interpolation of these.
"""

from dataclasses import fields

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from comparing import close
from fem.symmetry import (
    MIRROR_X,
    MIRROR_Z,
    LoadedSurface,
    NodalLoads,
    pin_load,
    pin_surfaces,
    symmetry_classes,
    unit_pin_loads,
)
from refusals import refused

ROUND_OFF = 1e-12
CYLINDER = 2e-3
NONE = np.zeros(3)

components = st.floats(-1e6, 1e6).map(lambda value: round(value, 3))
vectors = st.tuples(components, components, components).map(np.array)


@pytest.fixture(scope="module", params=["quarter", "half", "full"])
def part(request, mesh, half_mesh, full_mesh):
    return {"quarter": mesh, "half": half_mesh, "full": full_mesh}[request.param]


@pytest.fixture(scope="module")
def surface(mesh):
    return pin_surfaces(mesh)[0]


class Listening(LoadedSurface):
    """A surface that tells which tractions are put on it."""

    def nodal(self, tractions):
        self.heard.append(tractions)
        return super().nodal(tractions)


def tractions_of(surface, force, moment, distribution):
    """Tractions, normals, arms from the center and areas at all quadrature points of all images."""
    listening = Listening(**{one.name: getattr(surface, one.name) for one in fields(surface)})
    object.__setattr__(listening, "heard", [])
    pin_load(listening, np.asarray(force, float), np.asarray(moment, float), distribution)
    (tractions,) = listening.heard
    found = []
    for image, traction in zip(surface.images, tractions, strict=True):
        arms, areas = surface.on_image(image)
        sizes = np.linalg.norm(areas, axis=1)
        found.append(np.column_stack([traction, areas / sizes[:, None], arms, sizes]))
    whole = np.vstack(found)
    return whole[:, 0:3], whole[:, 3:6], whole[:, 6:9], whole[:, 9]


def places(mesh, loads):
    """Where the loads of each image act (images, s, 3)."""
    return np.array([image.points(mesh.points[loads.nodes]) for image in loads.images])


def resultants(mesh, loads, center):
    """Forces and moments (6, c) of all nodal loads on all images, about a center."""
    arms = places(mesh, loads) - center
    moments = np.cross(arms[..., None], loads.values, axis=2)
    return np.concatenate([loads.values.sum(axis=(0, 1)), moments.sum(axis=(0, 1))])


def test_unit_loads_on_pins_have_unit_resultants(part, throw):
    (loads,) = unit_pin_loads(part)
    center = np.array([0.0, throw.crank_radius, throw.length / 2.0])
    assert resultants(part, loads, pin_surfaces(part)[0].center) == close(np.eye(6), abs=ROUND_OFF)
    assert pin_surfaces(part)[0].center == close(center, abs=5e-6)  # of a coarse mesh


@pytest.mark.parametrize("distribution", ["uniform", "cosine"])
@settings(max_examples=60, deadline=None)
@given(force=vectors, moment=vectors)
def test_any_load_has_its_resultants(mesh, surface, distribution, force, moment):
    loads = pin_load(surface, force, moment, distribution)
    found = resultants(mesh, loads, surface.center)[:, 0]
    wanted = np.concatenate([force, moment])
    # Pressures of a moment are as large as it is over the pin's length.
    size = np.abs(force).max() + np.abs(moment).max() / 0.1
    assert np.abs(found[:3] - wanted[:3]).max() <= 1e-11 * size
    assert np.abs(found[3:] - wanted[3:]).max() <= 1e-12 * size


@settings(max_examples=30, deadline=None)
@given(angle=st.floats(0.0, 6.28), size=st.floats(1.0, 1e6))
def test_a_force_across_presses_with_the_cosine_on_one_half(surface, throw, angle, size):
    """p = p0 cos(theta) on the half that the force presses on: P = p0 a l pi / 2, p0 = 4 P / (pi D l).

    theta is the angle from the line where the force meets the pin, l the length between the fillets. On
    the other half there is nothing but what corrects the resultants, some 1e-4 of p0.
    """
    direction = np.array([np.cos(angle), np.sin(angle), 0.0])
    traction, normals, _, _ = tractions_of(surface, size * direction, NONE, "cosine")
    length = throw.pin_length - 2.0 * throw.fillet_radius
    highest = 4.0 * size / (np.pi * throw.pin_diameter * length)
    pressure = -np.einsum("qa,qa->q", traction, normals)
    expected = highest * np.maximum(0.0, -normals @ direction)
    assert np.abs(pressure - expected).max() <= CYLINDER * highest
    assert np.abs(traction + pressure[:, None] * normals).max() <= CYLINDER * highest
    assert pressure.max() == close(highest, rel=0.01)
    loaded = expected > CYLINDER * highest
    assert np.all(pressure[loaded] > 0.0)
    assert 0.4 < loaded.mean() < 0.6


@settings(max_examples=25, deadline=None)
@given(force=vectors, moment=vectors, factor=st.floats(1e-3, 1e3))
def test_pressures_grow_with_the_load_and_mirror_with_it(surface, force, moment, factor):
    """A load pressed by a larger force is larger; pushed the other way it is another one."""
    size = np.abs(force).max() + 10.0 * np.abs(moment).max()
    assume(size > 1.0)
    loads = pin_load(surface, force, moment, "cosine").values
    grown = pin_load(surface, factor * force, factor * moment, "cosine").values
    assert np.abs(grown - factor * loads).max() <= 1e-11 * factor * size
    # Images: itself, across the middle plane, across the crank plane, across both.
    for signs, images in ((MIRROR_X, [2, 3, 0, 1]), (MIRROR_Z, [1, 0, 3, 2])):
        mirrored = pin_load(surface, signs[:3] * force, signs[3:] * moment, "cosine").values
        assert np.abs(mirrored - loads[images] * signs[:3, None]).max() <= 1e-11 * size


def test_a_load_pressed_from_the_other_side_is_another_one(surface):
    one, other = (
        pin_load(surface, np.array([0.0, sign, 0.0]), NONE, "cosine").values for sign in (1.0, -1.0)
    )
    assert np.abs(one + other).max() > 0.5 * np.abs(one).max()


@pytest.mark.parametrize("name", ["quarter", "half", "full"])
def test_loads_of_a_class_work_as_those_on_all_images(mesh, half_mesh, full_mesh, name):
    """A field of a class goes on in each image with the signs that keep it whole on the cuts."""
    found = {"quarter": mesh, "half": half_mesh, "full": full_mesh}[name]
    (loads,) = unit_pin_loads(found)
    rng = np.random.default_rng(8)
    works = np.zeros(6)
    for symmetry in symmetry_classes(name):
        field = rng.normal(size=(len(loads.nodes), 3))
        for image in loads.images:
            at = image.points(found.points[loads.nodes])
            on_cut = np.abs(at - found.points[loads.nodes]).max(axis=1) < 1e-12
            field[np.ix_(on_cut, symmetry.parity(image) * image.signs < 0.0)] = 0.0
        whole = [symmetry.parity(image) * image.signs * field for image in loads.images]
        expected = np.einsum("isac,isa->c", loads.values, whole)
        work = np.einsum("sac,sa->c", loads.of_class(symmetry), field)
        assert work == close(expected, abs=ROUND_OFF)
        # Components that the class does not have do no work.
        assert np.abs(work[~symmetry.central_motions]).max(initial=0.0) <= 1e-10
        works += np.abs(work)
    assert np.all(works > 1e-3)


@pytest.mark.parametrize("distribution", ["even", "", None, "Cosine"])
def test_unknown_distributions_are_refused(surface, distribution):
    with refused("distribution"):
        pin_load(surface, np.array([1.0, 0.0, 0.0]), NONE, distribution)


def test_no_load_is_none(surface):
    for distribution in ("uniform", "cosine"):
        loads = pin_load(surface, NONE, NONE, distribution)
        assert isinstance(loads, NodalLoads)
        assert not loads.values.any()
