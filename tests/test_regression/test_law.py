import re
import subprocess
import sys

import numpy as np
import pytest

from comparing import close
from crankbase.errors import InputError
from fem.supports import Neighbors
from geometry.throw import CrankThrow
from geometry.throw_dimensions import OilHole, Web
from refusals import refusals, refusals_of, refused
from regression.law.superelement import law_reactions
from regression.law.throw_law import (
    axial_law,
    axial_law_slopes,
    axial_laws,
    dimension_ranges,
    hand_formula,
    mass_law,
    throw_laws,
    torsional_law,
    torsional_laws,
)
from throws import MEDIUM_SPEED

DIMENSIONS = MEDIUM_SPEED | {"web_width": 0.3}
THROW = CrankThrow(**DIMENSIONS)
LENGTHS = ("main_journal_length", "pin_length")
MANY = DIMENSIONS | {"web_thickness": np.array([0.050, 0.068, 0.090])}


@pytest.mark.parametrize("scale", [2.0, 0.01, 1.0 / 3.0])
def test_all_lengths_scaled_scale_compliances_exactly(scale):
    scaled = CrankThrow(**{name: scale * value for name, value in DIMENSIONS.items()})
    axial, of_scaled = axial_law(THROW), axial_law(scaled)
    for name in ("pinned", "guided", "influence_pinned", "influence_guided"):
        np.testing.assert_allclose(
            getattr(of_scaled, name) * scale, getattr(axial, name), rtol=1e-12
        )
    np.testing.assert_allclose(of_scaled.ratio, axial.ratio, rtol=1e-12)
    twists = torsional_law(THROW).pinned, torsional_law(scaled).pinned * scale**3
    np.testing.assert_allclose(*twists, rtol=1e-12)


BORES = {"main_journal_bore": 0.06, "pin_bore": 0.05}


@pytest.mark.parametrize("more", [{}, BORES])
def test_slopes_of_the_law(more):
    """All lengths longer by one per cent make e_n less by as much: the slopes add up to -1."""
    throw = CrankThrow(**DIMENSIONS | more)
    slopes = axial_law_slopes(throw)
    assert slopes.keys() == {*DIMENSIONS, *more}
    assert sum(slopes.values()) == close(-1.0, 2e-3)
    step = 1e-4
    for name, slope in slopes.items():
        ends = [throw.changed(**{name: getattr(throw, name) * (1.0 + s)}) for s in (step, -step)]
        high, low = (axial_law(end).pinned for end in ends)
        assert slope == close(np.log(high / low) / (2.0 * step), rel=2e-3, abs=2e-3)


def test_slopes_at_an_end_of_the_law_are_of_one_side():
    inside = axial_law_slopes(THROW)
    end = dimension_ranges(THROW)["web_width"]["high"]
    at_end = axial_law_slopes(THROW.changed(web_width=end))
    assert at_end.keys() == inside.keys()
    between = [axial_law(THROW.changed(web_width=share * end)).pinned for share in (0.99, 1.0)]
    assert at_end["web_width"] == close(-np.log(between[1] / between[0]) / np.log(0.99), rel=1e-9)


@pytest.mark.parametrize("more", [{}, BORES])
def test_the_law_ends_where_the_range_of_a_dimension_does(more):
    known = {**DIMENSIONS, **more}
    ranges = dimension_ranges(CrankThrow(**known))
    for name in known:
        ends = ranges[name]
        assert ends["low"] < known[name] < ends["high"]
        for end, beyond in (("low", 0.999), ("high", 1.001)):
            # The wall ends a bore earlier.
            if not ends[end] or (name.endswith("_bore") and end == "high"):
                continue
            # The ratio that is told is the nearest there, and refused beyond.
            ratio = ends[f"{end}_limit"].partition(" = ")[0]
            assert axial_law(CrankThrow(**known | {name: ends[end]})).nearest_limit.startswith(
                ratio
            )
            with pytest.raises(InputError, match=re.escape(ratio)):
                axial_law(CrankThrow(**known | {name: beyond * ends[end]}))


def test_dimensions_that_are_not_given_have_the_ranges_of_the_law_too():
    ranges = dimension_ranges(THROW)
    assert ranges["pin_bore"]["low"] == 0.0
    for name in ("pin_bore", "main_journal_bore", "web_pin_end", "web_tip_thickness"):
        assert name not in DIMENSIONS
        law = axial_law(CrankThrow(**DIMENSIONS, **{name: ranges[name]["high"]}))
        # A full tip is what every throw without a slope has: no limit.
        assert law.nearest_limit.startswith(name) == (name != "web_tip_thickness")
        with pytest.raises(InputError):
            axial_law(CrankThrow(**DIMENSIONS, **{name: 1.001 * ranges[name]["high"]}))


def test_youngs_modulus_enters_exactly():
    assert axial_law(THROW, youngs_modulus=1.05e11).pinned == 2.0 * axial_law(THROW).pinned


def test_many_throws_have_the_answers_of_each():
    axial, torsional = axial_laws(**MANY), torsional_laws(**MANY)
    for place, thickness in enumerate(MANY["web_thickness"].tolist()):
        throw = THROW.changed(web_thickness=thickness)
        for law, found in ((axial_law(throw), axial), (torsional_law(throw), torsional)):
            for name in found.errors:
                np.testing.assert_allclose(getattr(found, name)[place], getattr(law, name), 1e-13)
                np.testing.assert_allclose(found.errors[name][place], law.errors[name], 1e-13)
            assert found.tier[place] == law.tier
    assert np.all(np.diff(axial.pinned) < 0.0)


def test_plain_and_bored_throws_together_have_the_answers_of_each():
    bores = [0.0, 0.060, 0.090]
    found = axial_laws(**DIMENSIONS, pin_bore=bores, poisson_ratio=0.28)
    both = [throw_laws(THROW.changed(pin_bore=bore), poisson_ratio=0.28) for bore in bores]
    assert [axial.tier for axial, _ in both] == found.tier.tolist() == ["plain", "real", "real"]
    for place, (axial, torsional) in enumerate(both):
        for name in found.errors:
            np.testing.assert_allclose(getattr(found, name)[place], getattr(axial, name), 1e-13)
        alone = torsional_law(THROW.changed(pin_bore=bores[place]), poisson_ratio=0.28)
        np.testing.assert_allclose(torsional.pinned, alone.pinned, 1e-13)
        assert torsional.errors.keys() == alone.errors.keys()


def test_the_band_lies_about_the_value():
    law = axial_law(THROW)
    low, high = law.band
    assert low < law.pinned < high
    assert high - low == close(2.0 * law.errors["pinned"] * law.pinned)


def test_bands_grow_from_those_of_a_plain_throw():
    plain, *others = (
        axial_law(THROW.changed(web_tip_thickness=tip)) for tip in (0.068, 0.0679, 0.066, 0.062)
    )
    assert [law.tier for law in (plain, *others)] == ["plain", "real", "real", "real"]
    for name, error in plain.errors.items():
        assert others[0].errors[name] == close(error, rel=0.05)
        assert np.all(np.diff([law.errors[name] for law in others]) > 0.0)


test_what_the_law_does_not_know_is_refused = refusals_of(
    lambda changes: axial_law(THROW.changed(**changes)),
    ({"crank_radius": 0.5}, "crank_radius / main_journal_diameter"),
    ({"web_width": 0.50}, "web_width / main_journal_diameter"),
    ({"pin_bore": 0.12, "pin_bore_offset": 0.012}, "pin_bore"),
    ({"oil_holes": (OilHole(part="pin", diameter=0.015),)}, "throw.oil_holes"),
    ({"left_web": Web(width=0.32)}, "throw.left_web.width"),
)


@pytest.mark.parametrize("poisson_ratio", [0.2, 0.4, float("nan"), "0.3"])
def test_other_poisson_ratios_are_refused(poisson_ratio):
    with refused("poisson_ratio"):
        axial_law(THROW, poisson_ratio=poisson_ratio)


@pytest.mark.parametrize(
    ("changes", "field"),
    [
        ({"web_depth": 0.1}, "web_depth"),
        ({"pin_length": None}, "pin_length"),
        ({"pin_length": -0.1}, "pin_length"),
        ({"pin_length": float("nan")}, "pin_length"),
        ({"pin_length": [0.13, 0.14]}, "dimensions"),
    ],
)
def test_wrong_dimensions_of_many_throws_are_refused(changes, field):
    given = {name: value for name, value in (MANY | changes).items() if value is not None}
    with pytest.raises(InputError, match=rf"^{field}: [^\n]+\.$"):
        axial_laws(**given)


def test_the_axial_reaction_is_that_of_the_compliances():
    law = axial_law(THROW)
    push = law_reactions(THROW, (0.0, -1.0, 0.0), "guided").left.force[2]
    assert push == close(law.influence_guided / law.guided, rel=1e-10)
    between = law_reactions(THROW, (0.0, -1.0, 0.0), Neighbors(120.0, 120.0)).left.force[2]
    assert between == close(law.influence(120.0) / law.axial(120.0), rel=1e-8)


def test_the_mass_follows_size_and_density_and_knows_no_counterweights():
    found = mass_law(THROW)
    assert found.band[0] < found.mass < found.band[1]
    doubled = CrankThrow(**{name: 2.0 * value for name, value in DIMENSIONS.items()})
    assert mass_law(doubled, density=2700.0).mass == close(found.mass * 8.0 * 2700.0 / 7850.0)
    for density in (0.0, float("nan"), "steel"):
        with refused("density"):
            mass_law(THROW, density=density)
    sector = {"outer_radius": 0.3, "inner_radius": 0.12, "angle": 2.0}
    for weighted, message in (
        ({"counterweight": sector}, r"throw\.counterweight: given one"),
        ({"left_web": {"counterweight": sector}}, r"throw\.left_web\.counterweight: given one"),
    ):
        with pytest.raises(InputError, match=message):
            mass_law(CrankThrow(**DIMENSIONS, **weighted))


@pytest.mark.slow
def test_by_hand_journals_are_bars_and_a_pin_is_a_beam_and_a_bar():
    area, second = np.pi * 0.22**2 / 4.0, np.pi * 0.18**4 / 64.0
    longer = {name: THROW.changed(**{name: DIMENSIONS[name] + 0.02}) for name in LENGTHS}
    added = {
        name: (hand_formula(throw).value - hand_formula(THROW).value) * 2.1e11 / 0.02
        for name, throw in longer.items()
    }
    assert added["main_journal_length"] == close(1.16 / area, rel=1e-9)
    bar = 1.16 * (0.22 / 0.18) ** 2 / area
    assert added["pin_length"] == close(THROW.crank_radius**2 / second + bar, rel=1e-9)


def test_the_law_loads_no_mesher_and_no_solver():
    code = (
        "import sys, crankfem as cf; cf.axial_law, cf.torsional_law;"
        "print([n for n in ('gmsh', 'vtk', 'pyvista', 'scipy', 'skfem', 'pandas') if n in sys.modules])"
    )
    found = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert found.stdout.strip() == "[]"


test_refused = refusals(
    ("pin_force", lambda: law_reactions(THROW, (0.0, 0.0, 1.0))),
    ("throw", lambda: law_reactions(THROW.changed(left_web=Web(thickness=0.08)), (0.0, -1.0, 0.0))),
)
