"""Stresses on surfaces and at fillets, and their fields."""

import math
from dataclasses import replace

import numpy as np
import pytest

from comparing import close
from crankbase.errors import InputError
from fem import fillet_stress
from fem.fields import displacement_field, images, stress_fields
from fem.fillet_peaks import (
    LoadedThrow,
    as_components,
    as_matrices,
    fillet_points,
    fillet_surface,
    reading_quality,
    sharp_corners,
    solve_unit_loads,
    surface_stress,
    throw_fillets,
    unit_loads,
    von_mises,
)
from fem.fillet_stress import fillet_stresses, nominal_stress, torsion_modulus, web_section
from fem.material import STEEL, Material
from fem.solver import assemble_stiffness, symmetric_product
from fem.superelement import nodes_on
from fem.symmetry import SymmetryClass, radial_directions
from fem.whole_throw import whole_nodes
from geometry.imported import import_throw
from geometry.mesh import mesh_throw
from geometry.sizes import SizeMap
from geometry.solid import LEFT_END, RIGHT_END
from geometry.solid_files import write_step
from geometry.throw import CrankThrow
from refusals import refusals, refused
from stand_ins import stress_coarsely

pytestmark = pytest.mark.slow

GENERATOR = np.random.default_rng(7)
AXIAL, TORSION, BENDING, CROSS_BENDING, RADIAL = range(5)


def rotation(seed=3):
    turned, _ = np.linalg.qr(np.random.default_rng(seed).normal(size=(3, 3)))
    return turned * np.sign(np.linalg.det(turned))


# ----------------------------------------------------------------------------------- principal stresses


def test_components_and_matrices_are_each_others_inverse():
    stress = GENERATOR.normal(size=(4, 6))
    matrices = as_matrices(stress)
    assert np.array_equal(matrices, matrices.swapaxes(1, 2))
    assert matrices[0, 1, 2] == stress[0, 4]
    assert np.array_equal(as_components(matrices), stress)


def test_equivalent_stress_of_known_states():
    tension, shear, pressure = [-3.0, 0, 0, 0, 0, 0], [0, 0, 0, 0, 2.0, 0], [5.0, 5.0, 5.0, 0, 0, 0]
    expected = [3.0, 2.0 * math.sqrt(3.0), 0.0]
    assert von_mises(np.array([tension, shear, pressure])) == close(expected)


# --------------------------------------------------------------------------------------- free surfaces


def grid(count, place):
    """Six-node facets of a square of parameters, count by count, at `place` (n, 2) -> (n, 3)."""
    side = np.arange(2 * count + 1)
    number = side[:, None] * len(side) + side
    facets = []
    for i in range(0, 2 * count, 2):
        for j in range(0, 2 * count, 2):
            n = number[i : i + 3, j : j + 3]
            facets.append([n[0, 0], n[2, 0], n[0, 2], n[1, 0], n[1, 1], n[0, 1]])
            facets.append([n[2, 2], n[0, 2], n[2, 0], n[1, 2], n[1, 1], n[2, 1]])
    parameters = np.array([(u, v) for u in side for v in side]) / (2.0 * count)
    return place(parameters), np.array(facets)


def stress_on(points, facets, displacement, material=STEEL):
    everywhere = np.full(len(facets), True)
    found = surface_stress(points, facets, everywhere, displacement[:, :, None], material)
    assert np.array_equal(np.sort(found.nodes), np.arange(len(points)))
    stress = np.empty((len(points), 6))
    stress[found.nodes] = found.stress[:, 0]
    return stress


def test_quadratic_displacements_of_a_plane_have_linear_stresses():
    """Exact but for what holds polynomials back: 1e-5 of the samples, twice that in a corner."""
    turn = rotation()
    flat, facets = grid(4, lambda p: np.column_stack([p, 0.0 * p[:, 0]]))
    x, y, _ = flat.T
    moved = np.column_stack([x * x - 2.0 * x * y, 3.0 * y + x * y, 5.0 * x - y * y])
    strains = np.column_stack([2.0 * x - 2.0 * y, 3.0 + x, 0.5 * (y - 2.0 * x)])
    modulus, ratio = STEEL.youngs_modulus, STEEL.poisson_ratio
    factor = modulus / (1.0 - ratio**2)
    expected = np.zeros((len(flat), 3, 3))
    expected[:, 0, 0] = factor * (strains[:, 0] + ratio * strains[:, 1])
    expected[:, 1, 1] = factor * (strains[:, 1] + ratio * strains[:, 0])
    expected[:, 0, 1] = expected[:, 1, 0] = modulus / (1.0 + ratio) * strains[:, 2]
    found = as_matrices(stress_on(flat @ turn.T, facets, moved @ turn.T))
    size = np.abs(expected).max()
    assert turn.T @ found @ turn / size == close(expected / size, abs=2e-5)


def cylinder(count, angle=1.2):
    def place(parameters):
        turned, z = angle * parameters[:, 0], 1.5 * parameters[:, 1]
        return np.column_stack([np.cos(turned), np.sin(turned), z])

    return grid(count, place)


def test_rigid_motion_leaves_a_curved_surface_without_stress():
    points, facets = cylinder(3)
    moved = np.array([1.0, 2.0, 3.0]) + np.cross([0.3, -0.2, 0.5], points)
    assert np.abs(stress_on(points, facets, moved)).max() < 1e-12 * STEEL.youngs_modulus


def test_a_bent_cylinder_has_the_stress_of_a_beam():
    """Errors fall with the square of the facets' size, here 0.3 and 0.15 of the radius.

    They are fifty times larger at the rim, where a patch may be a single facet.
    """
    inside, anywhere = [], []
    for count in (4, 8):
        points, facets = cylinder(count)
        x, y, z = points.T
        ratio = STEEL.poisson_ratio
        moved = np.column_stack([-ratio * x * y, -0.5 * (z**2 + ratio * (y**2 - x**2)), y * z])
        stress = stress_on(points, facets, moved / STEEL.youngs_modulus)
        errors = np.abs(stress - np.outer(y, np.eye(6)[2])).max(axis=1)
        away = (np.abs(np.arctan2(y, x) - 0.6) < 0.35) & (np.abs(z - 0.75) < 0.45)
        inside.append(errors[away].max())
        anywhere.append(errors.max())
    assert inside[0] < 1e-3
    assert inside[1] < 0.3 * inside[0]
    assert anywhere[1] < 0.3 * anywhere[0] < 0.01


# ------------------------------------------------------------------------- unit loads on parts of a throw


@pytest.fixture(scope="module")
def loads(throw):
    return unit_loads(radial_directions(throw))


@pytest.fixture(scope="module")
def loaded(mesh, half_mesh, full_mesh, loads):
    meshes = {"quarter": mesh, "half": half_mesh, "full": full_mesh}
    return {part: solve_unit_loads(found, loads, STEEL) for part, found in meshes.items()}


def in_order(points, values):
    """Values sorted by place, so that nodes of different numbering can be compared."""
    order = np.lexsort((points / np.ptp(points)).round(7).T)
    return points[order], values[order]


@pytest.mark.parametrize("part", ["quarter", "half"])
def test_parts_have_the_stresses_of_the_whole(loaded, part):
    found, whole = fillet_surface(loaded[part]), fillet_surface(loaded["full"])
    places, stress = in_order(found.points, found.stress)
    expected_places, expected = in_order(whole.points, whole.stress)
    assert places == close(expected_places, abs=1e-12)
    size = np.abs(expected).max(axis=(0, 2))
    assert stress / size[:, None] == close(expected / size[:, None], abs=1e-7)


def test_only_the_classes_that_loads_excite_are_solved(loaded, mesh, loads):
    assert len(loaded["quarter"].shares) == 3
    assert len(solve_unit_loads(mesh, loads[:1], STEEL).shares) == 1
    for load, found in enumerate((1, 1, 1, 1, 1)):
        fields = [np.any(field[:, :, load]) for _, field in loaded["quarter"].shares]
        assert sum(fields) == found


@pytest.mark.parametrize("kind", ["rigid", "averaged"])
def test_end_sections_carry_the_loads(loads, full_mesh, throw, kind):
    """Forces and moments that act on the full mesh's ends, from its stiffness."""
    stiffness = assemble_stiffness(full_mesh.points, full_mesh.elements, STEEL)
    found = solve_unit_loads(full_mesh, loads, STEEL, end_sections=kind)
    assert found.end_sections == kind
    displacement = found.displacement(whole_nodes(full_mesh).images[0])
    forces = symmetric_product(stiffness, displacement.reshape(-1, 5)).reshape(-1, 3, 5)
    ends = {}
    for end, z in ((LEFT_END, 0.0), (RIGHT_END, throw.length)):
        nodes = nodes_on(full_mesh, end)
        arms = full_mesh.points[nodes] - (0.0, 0.0, z)
        moments = np.cross(arms[:, :, None], forces[nodes], axis=1)
        ends[end] = np.concatenate([forces[nodes].sum(axis=0), moments.sum(axis=0)])
    right = np.zeros((6, 5))
    right[2, AXIAL] = right[5, TORSION] = right[4, CROSS_BENDING] = 1.0
    right[3, BENDING] = -1.0
    # Bearings push the shaft up against a force towards it.
    right[1, RADIAL] = 0.5
    left = -right
    left[1, RADIAL] = 0.5
    assert ends[RIGHT_END] == close(right, abs=1e-6)
    assert ends[LEFT_END] == close(left, abs=1e-6)


# -------------------------------------------------------------------- fillets and their nominal stresses


def test_fillets_hold_all_their_nodes(throw, full_mesh):
    points = fillet_points(full_mesh)
    holders = sum(fillet.holds(points).astype(int) for fillet in throw_fillets(throw.parts))
    assert np.array_equal(holders, np.ones(len(points)))


def test_names_of_fillets_and_corners(dimensions):
    plain = CrankThrow(**dimensions)
    names = ("left main journal", "pin, left web", "pin, right web", "right main journal")
    assert tuple(fillet.name for fillet in throw_fillets(plain.parts)) == names
    assert sharp_corners(plain.parts) == ()
    half = CrankThrow(**dimensions, pin_fillet_radius=0.0)
    assert tuple(fillet.name for fillet in throw_fillets(half.parts)) == (names[0], names[3])
    assert sharp_corners(half.parts) == (names[1], names[2])
    split = {"further_pins": [{"angle": 0.5, "web_thickness": 0.0}]}
    split_pin = CrankThrow(**dimensions, **split)
    found = tuple(fillet.name for fillet in throw_fillets(split_pin.parts))
    assert found == (names[0], names[1], "pin 2, right web", names[3])
    assert sharp_corners(split_pin.parts) == ("pin and pin 2 where they meet",)


def nominal(throw, kind, fillet=0, pin=None):
    fillets = throw_fillets(throw.parts)
    found = unit_loads(radial_directions(throw))
    load = next(one for one in found if one.kind == kind and (pin is None or one.pin == pin))
    return nominal_stress(throw.parts, fillets[fillet], load)


def test_nominal_stresses_by_hand(dimensions):
    throw = CrankThrow(**dimensions, main_journal_bore=0.1)
    modulus = 0.3 * 0.068**2 / 6.0
    assert nominal(throw, "axial") == close(0.17 / modulus)
    assert nominal(throw, "bending", 2) == close(1.0 / modulus)
    journal = math.pi * (0.22**4 - 0.1**4) / (16.0 * 0.22)
    pin = math.pi * 0.18**3 / 16.0
    assert nominal(throw, "torsion", 0) == close(1.0 / journal)
    assert nominal(throw, "torsion", 1) == close(1.0 / pin)
    assert nominal(throw, "cross bending", 2) == close(2.0 / pin)
    # From the bearing 60 + 34 mm to the middle of the web; half of the force there.
    assert nominal(throw, "radial") == close(0.5 * 0.094 / modulus)


def test_nominal_stresses_of_several_pins(dimensions):
    throw = CrankThrow(
        **dimensions, further_pins=[{"angle": math.pi, "web_thickness": 0.12, "web_width": 0.32}]
    )
    parts = throw.parts
    fillet = next(one for one in throw_fillets(parts) if one.name == "pin 2, web 2")
    middle = web_section(parts, parts.webs[1])
    # Between pins 340 mm apart, of one radius: the middle of the gap is on the shaft.
    assert (middle.width, middle.thickness) == close((0.32, 0.12))
    number = throw_fillets(parts).index(fillet)
    assert nominal(throw, "axial", number) == close(0.17 / middle.modulus)
    assert torsion_modulus(fillet.journal) == close(math.pi * 0.18**3 / 16.0)
    second = 0.5 * (parts.pins[1].start + parts.pins[1].end)
    moment = (0.5 * throw.length) * (throw.length - second) / throw.length
    assert nominal(throw, "radial", number, pin=1) == close(moment / middle.modulus)
    names = [load.name for load in unit_loads(radial_directions(throw))]
    assert names[-2:] == ["radial force on pin 1", "radial force on pin 2"]


# ------------------------------------------------------------------------------------------- whole runs


@pytest.fixture
def coarsely(monkeypatch):
    """Meshes as coarse as can be, for what does not depend on accuracy."""
    stress_coarsely(monkeypatch)


def test_result_of_a_run(coarsely, dimensions):
    throw = CrankThrow(**dimensions)
    sizes = []

    def mesher(one, factor, part, wished):
        sizes.append(wished)
        return mesh_throw(one, factor, part, wished)

    found = fillet_stresses(throw, accuracy=0.2, mesher=mesher)
    assert sizes[0] is None
    assert all(isinstance(wished, SizeMap) for wished in sizes[1:])
    assert found.loaded.mesh.part == "quarter"
    assert len(found.peaks) == 5 * 4
    for load in found.loaded.loads:
        left, pin_left, pin_right, right = found.under(load)
        for one, other in ((left, right), (pin_left, pin_right)):
            assert one.von_mises == close(other.von_mises)
            sign = -1.0 if load.kind == "torsion" else 1.0
            assert one.principal == close(sign * other.principal)
            mirrored = one.von_mises_place * (1.0, 1.0, -1.0) + (0.0, 0.0, throw.length)
            assert other.von_mises_place == close(mirrored)
    for peak in found.peaks:
        assert peak.principal_place[0] >= 0.0
        assert peak.fillet.holds(np.array([peak.principal_place, peak.von_mises_place])).all()
        assert abs(peak.principal) == close(np.abs(peak.principals).max())
        assert np.abs(peak.principals).min() < 1e-6 * abs(peak.principal)
        assert peak.factor == close(abs(peak.principal) / peak.nominal)
        assert peak.von_mises_factor == close(peak.von_mises / peak.nominal)
        assert peak.error_estimate >= fillet_stress.SCATTER / found.fineness
    assert found.error_estimate == max(peak.error_estimate for peak in found.peaks)
    assert found.accuracy_met == (found.error_estimate <= 0.2)


def test_stress_depends_on_poissons_ratio_alone(mesh, loads, loaded):
    soft = Material(youngs_modulus=7e10, poisson_ratio=0.3, density=2700.0)
    found = fillet_surface(solve_unit_loads(mesh, loads, soft)).stress
    expected = fillet_surface(loaded["quarter"]).stress
    size = np.abs(expected).max(axis=(0, 2))[:, None]
    assert found / size == close(expected / size, abs=1e-7)


@pytest.mark.parametrize(
    ("changes", "arguments", "field"),
    [
        ({"fillet_radius": 0.0}, {}, "fillet_radius"),
        ({}, {"accuracy": 0.001}, "accuracy"),
        ({}, {"material": "steel"}, "material"),
        ({}, {"mesh": "fine"}, "mesh"),
        ({}, {"end_sections": "soft"}, "end_sections"),
    ],
)
def test_refusals(dimensions, changes, arguments, field):
    with refused(field):
        fillet_stresses(CrankThrow(**dimensions | changes), mesher=mesh_throw, **arguments)


@pytest.mark.parametrize(
    ("changes", "field"),
    [
        ({"fillet_radius": 0.003}, "fillet_radius"),
        (
            {"oil_holes": [{"part": "pin", "diameter": 0.012, "exit_radius": 0.002}]},
            "oil_holes[0].exit_radius",
        ),
    ],
)
def test_refuses_fillets_too_small_for_the_budget(monkeypatch, dimensions, changes, field):
    monkeypatch.setattr(fillet_stress, "MOST_UNKNOWNS", 15_000)
    with refused(field):
        fillet_stresses(CrankThrow(**dimensions | changes), mesher=mesh_throw)


@pytest.mark.further
def test_estimates_hold_against_a_finer_mesh(dimensions):
    """The finer run's own estimate is added: it is no exact value either.

    Large fillets have large elements, so few that even the finer mesh is soon solved. What is left of the
    room is as little as with fillets of 12 mm: the largest differences take 0.39 of it, there 0.32.
    """
    throw = CrankThrow(**dimensions | {"fillet_radius": 0.018})
    usual = fillet_stresses(throw, mesher=mesh_throw)
    finer = fillet_stresses(throw, accuracy=0.02, mesher=mesh_throw)
    assert usual.accuracy_met
    assert finer.fineness >= 7.5 > usual.fineness
    for one, other in zip(usual.peaks, finer.peaks, strict=True):
        room = one.error_estimate + other.error_estimate
        assert one.von_mises == close(other.von_mises, rel=room)
        assert one.principal == close(other.principal, rel=room)


# --------------------------------------------------------------------------------- meshes of UR M53


@pytest.fixture(scope="module")
def by_rule(dimensions):
    """Large fillets, which take few elements."""
    throw = CrankThrow(**dimensions | {"fillet_radius": 0.02})
    return fillet_stresses(throw, accuracy=0.1, mesh="m53", mesher=mesh_throw)


@pytest.mark.further
def test_mesh_of_the_rule_is_as_fine_as_it_asks(by_rule):
    left, pin = by_rule.meshings
    assert (left.fillet, pin.fillet) == ("left main journal", "pin, left web")
    for meshing in (left, pin):
        assert meshing.met
        assert meshing.size_share <= 0.25
        assert meshing.size == close(0.02 * meshing.size_share)
        assert all(own <= most for own, most in zip(meshing.layers, (1.0, 2.0, 3.0), strict=True))
        assert meshing.across_web >= 6.0
    assert by_rule.rule_met
    for peak in by_rule.peaks:
        if peak.load.kind in ("torsion", "bending", "radial"):
            assert peak.quality.normal_share < 0.03
            assert peak.quality.spread <= 0.05


def test_criteria_of_the_rule_by_hand(full_mesh, loads):
    """Stretched along z without contraction, a body has nu / (1 - nu) of the stress across; no spread."""
    z = full_mesh.points[:, 2]
    node = int(full_mesh.elements[np.abs(z[full_mesh.elements[:, 0]] - 0.2).argmin(), 0])
    found = []
    for stretch in (z, np.abs(z - z[node])):
        field = np.zeros((*full_mesh.points.shape, 1))
        field[:, 2, 0] = stretch
        shares = ((SymmetryClass(0, 0), field),)
        loaded = LoadedThrow(full_mesh, STEEL, loads[:1], shares, "", "rigid")
        found.append(reading_quality(loaded, node, 0, shear=False))
    even, kinked = found
    assert even.spread == close(0.0, abs=1e-9)
    assert even.normal_share == close(0.3 / 0.7)
    assert not even.met
    assert kinked.spread > 0.5


def test_a_rule_mesh_beyond_the_budget_is_refused(monkeypatch, dimensions):
    monkeypatch.setattr(fillet_stress, "MOST_RULE_UNKNOWNS", 30_000)
    with refused("mesh"):
        fillet_stresses(CrankThrow(**dimensions), mesh="m53", mesher=mesh_throw)


@pytest.fixture(scope="module")
def fields(mesh, throw):
    return stress_fields(mesh, throw, STEEL)


@pytest.mark.slow
def test_exits_of_oil_holes_are_places_of_stress(throw):
    drilled = throw.changed(oil_holes=({"part": "pin", "diameter": 0.03},))
    sites = stress_fields(mesh_throw(drilled, 3.0), drilled, STEEL).sites
    exits = [site for site in sites if site.kind == "oil hole"]
    assert exits
    assert {(site.diameter, site.radius) for site in exits} == {(throw.pin_diameter, 0.015)}


def test_loads_out_of_balance_are_refused(fields):
    ends = np.zeros(12)
    ends[1] = 1.0
    with refused("loads"):
        fields.amplitudes(ends, np.zeros(6))


def test_strain_energy_is_that_of_the_amplitudes(fields):
    """End loads in balance do the work c^2 / 2 on the motions that they make."""
    motions = np.random.default_rng(3).normal(size=12)
    ends = fields.superelement.stiffness @ motions
    amplitudes = fields.amplitudes(ends, np.zeros(6))
    assert amplitudes[:6] @ amplitudes[:6] == close(motions @ ends)


def test_throws_of_several_pins_are_refused(mesh, throw):
    several = throw.changed(further_pins=({"angle": 1.0, "web_thickness": 0.06},))
    with refused("throw"):
        stress_fields(mesh, several, STEEL)


@pytest.fixture(scope="module")
def cad_throw(dimensions):
    return CrankThrow(**dimensions, main_journal_bore=0.06, right_web={"thickness": 0.055})


@pytest.fixture(scope="module")
def part(cad_throw, tmp_path_factory):
    return import_throw(write_step(cad_throw, tmp_path_factory.mktemp("cad") / "throw.step"))


@pytest.mark.further
def test_stresses_of_a_part_are_those_of_its_throw(dimensions, tmp_path):
    """Two meshes, each within its own estimate. Large fillets take few elements."""
    throw = CrankThrow(**dimensions | {"fillet_radius": 0.02})
    part = import_throw(write_step(throw, tmp_path / "throw.step"))
    expected, found = (fillet_stresses(one, accuracy=0.2) for one in (throw, part))
    assert found.loaded.mesh.part == "quarter"
    assert found.sharp_corners == ()
    for own, wanted in zip(found.peaks, expected.peaks, strict=True):
        assert (own.name, own.load.kind) == (wanted.name, wanted.load.kind)
        assert own.nominal == close(wanted.nominal, rel=3e-3)
        room = own.error_estimate + wanted.error_estimate
        assert own.von_mises == close(wanted.von_mises, rel=room)


def test_a_part_without_fillets_is_refused(dimensions, tmp_path):
    sharp = CrankThrow(**dimensions | {"fillet_radius": 0.0})
    part = import_throw(write_step(sharp, tmp_path / "sharp.step"))
    with pytest.raises(InputError, match=r"sharp\.step: given a part without a fillet at its"):
        fillet_stresses(part)


# Finite elements throughout: not for the inner loop.


@pytest.fixture(scope="module")
def models(mesh, half_mesh, full_mesh, condensed):
    meshes = {"quarter": mesh, "half": half_mesh, "full": full_mesh}
    return {part: (found, condensed(found)[0]) for part, found in meshes.items()}


def rows_of(points, wanted):
    """Number of the node at each wanted place."""
    found = {tuple(place): number for number, place in enumerate(points.round(8) + 0.0)}
    return [found[tuple(place)] for place in wanted.round(8) + 0.0]


@pytest.mark.parametrize("part", ["quarter", "half", "full"])
def test_images_make_the_whole_throws_field(models, part):
    """Against the field of the full mesh, for motions with nothing symmetric in them."""
    motions = np.random.default_rng(5).normal(size=12)
    mesh, classes = models[part]
    full, whole = models["full"]
    expected = displacement_field(whole, motions)
    copies = images(mesh, classes, motions)
    assert len(copies) == {"quarter": 4, "half": 2, "full": 1}[part]
    assert np.array_equal(copies[0].points, mesh.points)
    assert copies[0].displacement == close(displacement_field(classes, motions))
    nodes = set()
    for copy in copies:
        rows = rows_of(full.points, copy.points)
        nodes.update(rows)
        assert copy.displacement == close(expected[rows], abs=1e-8)
    assert nodes == set(range(len(full.points)))
    assert sum(copy.inside_out for copy in copies) == len(copies) // 2


@pytest.mark.parametrize("part", ["quarter", "half"])
def test_recovered_stresses_of_images_are_mirrored(loaded, part):
    """Away from the cuts, where patches are halved, to the round-off of the solves."""
    one, whole = loaded[part], loaded["full"]
    nodes = whole_nodes(one.mesh)
    points = nodes.collect([image.points(one.mesh.points) for image in nodes.images])
    places, stress = in_order(points, nodes.collect(one.stresses(nodes.images)))
    full_nodes = whole_nodes(whole.mesh)
    expected_places, expected = in_order(whole.mesh.points, whole.stresses(full_nodes.images)[0])
    assert places == close(expected_places, abs=1e-12)
    away = (np.abs(places[:, 0]) > 0.06) & (np.abs(places[:, 2] - 0.5 * one.mesh.length) > 0.06)
    size = np.abs(expected).max(axis=(0, 2))
    assert away.sum() > 100
    difference = (stress - expected)[away] / size[:, None]
    assert np.abs(difference).max() < 1e-7


def test_nominal_section_lies_in_the_middle_of_the_overlap(dimensions):
    """Radii of 110 and 90 mm, axes 170 mm apart: 95 mm from the shaft."""
    throw = CrankThrow(
        **dimensions | {"web_thickness": 0.06}, web_pin_end=0.125, web_tip_thickness=0.05
    )
    web = throw.parts.webs[0]
    section = web_section(throw.parts, web)
    assert section.width == close(2.0 * web.outline.half_width(np.array([0.095]))[0])
    assert 0.25 < section.width < 0.299
    # The slope starts beyond the collar of the main journal.
    assert section.thickness == close(0.06)
    sloped = replace(web, slopes=(replace(web.slopes[0], start=0.05, end=0.295),))
    parts = replace(throw.parts, webs=(sloped, throw.parts.webs[1]))
    assert web_section(parts, sloped).thickness == close(0.06 - 0.01 * 0.045 / 0.245)


def test_parts_are_those_that_the_solid_was_made_of(cad_throw, part):
    """Lengths as the kernel has them; the width is measured on facets, which cut arcs short by 0.1 %."""
    found = part.parts_by(part.meshed(1.5))
    fillets, expected = throw_fillets(found), throw_fillets(cad_throw.parts)
    assert [fillet.name for fillet in fillets] == [fillet.name for fillet in expected]
    for one, other in zip(fillets, expected, strict=True):
        assert (one.radius, one.start, one.end) == close((other.radius, other.start, other.end))
        assert torsion_modulus(one.journal) == close(torsion_modulus(other.journal))
        own, wanted = web_section(found, one.web), web_section(cad_throw.parts, other.web)
        assert own.thickness == close(wanted.thickness)
        assert own.width == close(wanted.width, rel=2e-3)


def test_corners_of_a_part_without_a_fillet_are_named(dimensions, tmp_path, monkeypatch):
    stress_coarsely(monkeypatch)
    half = CrankThrow(**dimensions | {"pin_fillet_radius": 0.0})
    found = fillet_stresses(import_throw(write_step(half, tmp_path / "half.step")), accuracy=0.2)
    assert found.sharp_corners == ("pin, left web", "pin, right web")
    assert {peak.name for peak in found.peaks} == {"left main journal", "right main journal"}
    assert math.isfinite(found.error_estimate)


test_refused = refusals(
    ("throw", lambda: fillet_stresses("throw")),
)
