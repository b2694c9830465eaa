import math

import numpy as np
import pytest

from comparing import close
from crankbase.errors import InputError
from geometry import crankshaft
from geometry.crankshaft import Crankshaft, throw_masses
from geometry.mass import cylinder_mass_properties, mass_properties, mesh_mass_properties
from geometry.mesh import mesh_throw
from geometry.parts import counterweight_moment
from geometry.throw import CrankThrow

DENSITY = 7850.0


def cylinder(diameter, length, center):
    mass = DENSITY * np.pi / 4.0 * diameter**2 * length
    across = mass * (diameter**2 / 16.0 + length**2 / 12.0)
    return mass, center, np.diag([across, across, mass * diameter**2 / 8.0])


def obround(width, distance, thickness, z):
    """A plate: a rectangle between two half discs at y = 0 and y = distance."""
    radius = width / 2.0
    per_area = DENSITY * thickness
    rectangle, half_disc = width * distance, np.pi * radius**2 / 2.0
    mass = per_area * (rectangle + 2.0 * half_disc)
    # Second moments about the plate's middle; a half disc's centroid lies 4 r / (3 pi) from its chord.
    offset = 4.0 * radius / (3.0 * np.pi)
    xx = distance * width**3 / 12.0 + 2.0 * np.pi * radius**4 / 8.0
    yy = width * distance**3 / 12.0 + 2.0 * (
        np.pi * radius**4 / 8.0 - half_disc * offset**2 + half_disc * (distance / 2.0 + offset) ** 2
    )
    through = mass * thickness**2 / 12.0
    tensor = np.diag([per_area * yy + through, per_area * xx + through, per_area * (xx + yy)])
    return mass, np.array([0.0, distance / 2.0, z]), tensor


def composed(throw):
    """Mass, center and inertia of a throw without fillets, from its seven simple parts."""
    quarter = throw.main_journal_length / 4.0
    web_z = throw.main_journal_length / 2.0 + throw.web_thickness / 2.0
    parts = []
    for z in (quarter, throw.length - quarter):
        center = np.array([0.0, 0.0, z])
        parts.append(cylinder(throw.main_journal_diameter, 2.0 * quarter, center))
    for z in (web_z, throw.length - web_z):
        parts.append(obround(throw.web_width, throw.crank_radius, throw.web_thickness, z))
    pin_center = np.array([0.0, throw.crank_radius, throw.length / 2.0])
    parts.append(cylinder(throw.pin_diameter, throw.pin_length, pin_center))
    mass = sum(part[0] for part in parts)
    center = sum(part[0] * part[1] for part in parts) / mass
    inertia = np.zeros((3, 3))
    for part_mass, part_center, part_inertia in parts:
        arm = part_center - center
        inertia += part_inertia + part_mass * (arm @ arm * np.eye(3) - np.outer(arm, arm))
    return mass, center, inertia


@pytest.mark.parametrize(
    "change", [{}, {"crank_radius": 0.3, "pin_diameter": 0.2}, {"web_thickness": 0.038}]
)
def test_mass_properties_against_the_composed_solid(dimensions, change):
    throw = CrankThrow(**{**dimensions, "fillet_radius": 0.0, **change})
    found = mass_properties(mesh_throw(throw, 1.0), DENSITY)
    mass, center, inertia = composed(throw)
    assert found.mass == close(mass, rel=1e-10)
    assert found.mass == close(DENSITY * throw.volume, rel=1e-10)
    assert found.center == close(center, rel=1e-10, abs=1e-12)
    assert np.diag(found.inertia) == close(np.diag(inertia), rel=1e-9)
    assert found.inertia - np.diag(np.diag(found.inertia)) == close(np.zeros((3, 3)))
    about_shaft = inertia[2, 2] + mass * center[1] ** 2
    assert found.inertia_about_shaft == close(about_shaft, rel=1e-9)


def test_mass_grows_with_the_density_and_the_fillets(dimensions, coarse_mesh):
    light = mass_properties(coarse_mesh, DENSITY)
    heavy = mass_properties(coarse_mesh, 2.0 * DENSITY)
    assert heavy.mass == close(2.0 * light.mass, rel=1e-14)
    assert heavy.inertia == close(2.0 * light.inertia, rel=1e-14)
    assert heavy.center == close(light.center, rel=1e-14)
    assert light.mass > composed(CrankThrow(**{**dimensions, "fillet_radius": 0.0}))[0]


def test_mass_properties_of_the_whole_mirrored_mesh(dimensions, coarse_mesh):
    """Sum over all four mirror images of the quarter, without using the symmetry."""
    from geometry.shapes import element_quadrature

    throw = CrankThrow(**dimensions)
    found = mesh_mass_properties(coarse_mesh, DENSITY)
    where, volumes = element_quadrature(coarse_mesh.points, coarse_mesh.elements)
    images = []
    for side in (1.0, -1.0):
        images.append(where * (side, 1.0, 1.0))
        images.append(images[-1] * (1.0, 1.0, -1.0) + (0.0, 0.0, throw.length))
    points, masses = np.concatenate(images), DENSITY * np.tile(volumes, 4)
    center = masses @ points / masses.sum()
    arms = points - center
    inertia = (masses * (arms**2).sum(axis=1)).sum() * np.eye(3) - arms.T * masses @ arms
    assert found.mass == close(masses.sum(), rel=1e-12)
    assert found.center == close(center, rel=1e-12, abs=1e-14)
    assert found.inertia == close(inertia, rel=1e-11, abs=1e-11)


@pytest.mark.parametrize(
    "density", [math.nan, math.inf, -7850.0, 0.0, 1e308, "7850", True, None, [7850.0]]
)
def test_densities_of_no_body_are_refused(dimensions, density, monkeypatch):
    """Before anything is built, which takes a second."""
    monkeypatch.setattr(crankshaft, "shared_process", None)
    throw = CrankThrow(**dimensions)
    shaft = Crankshaft((throw,), crank_angles_deg=(0.0,))
    for call in (
        lambda: throw_masses(throw, density),
        lambda: shaft.masses(density),
        lambda: shaft.unbalance(density),
        lambda: cylinder_mass_properties(0.1, 0.0, 0.1, density),
    ):
        with pytest.raises(InputError, match=r"^density: given .*; allowed are numbers above 0"):
            call()


@pytest.mark.parametrize("density", [7850, 1.0, np.float64(7850.0), np.int64(7850)])
def test_densities_of_any_number_type_are_taken(density):
    assert cylinder_mass_properties(0.1, 0.0, 0.1, density).mass > 0.0


@pytest.mark.parametrize(
    "counterweight",
    [
        {"outer_radius": 0.3, "angle": 2.0},
        {
            "outer_radius": 0.32,
            "inner_radius": 0.12,
            "angle": 1.2,
            "thickness": 0.05,
            "offset": -0.004,
        },
    ],
)
def test_moment_of_counterweights_is_what_they_add_to_the_solid(dimensions, counterweight):
    dimensions = dimensions | {"web_foot_thickness": 0.06, "main_journal_bore": 0.05}
    plain = CrankThrow(**dimensions)
    for name in ("counterweight", "right_web"):
        part = {"counterweight": counterweight} if name == "right_web" else counterweight
        throw = CrankThrow(**dimensions, **{name: part})
        before, after = (throw_masses(one, DENSITY) for one in (plain, throw))
        added = (after.mass * after.center - before.mass * before.center)[:2]
        assert DENSITY * counterweight_moment(throw.parts) == close(added, rel=1e-7, abs=1e-9)
        assert added[1] < -0.1
