"""Factors of UR M53 by finite elements, beside the formulas and in their place."""

import math
from dataclasses import replace

import pytest

import crankfem as cf
from comparing import close
from crankbase.errors import InputError
from crankfem.analyses.strength import engine_strength
from crankfem.analyses.strength.cycle_loads import shaft_loads
from crankfem.analyses.strength.engine_strength import (
    EngineStrength,
    element_factors,
    factor_table,
    throw_webs,
)
from dynamics.strength.concentration import ElementFactors, unsafe_formulas
from fem import fillet_stress
from stand_ins import stress_coarsely

GIVEN = {
    "tensile_strength": 8e8,
    "manufacture": "continuous grain flow",
    "piston": "trunk",
    "oil_hole_diameter": 0.018,
}
FACTORS = {
    "alpha_bending": 2.5,
    "alpha_torsion": 1.7,
    "beta_bending": 2.0,
    "beta_shear": 2.1,
    "beta_torsion": 2.2,
    "beta_combined": 2.4,
    "gamma_bending": None,
    "gamma_torsion": None,
    "error": 0.02,
    "as_ruled": True,
}


@pytest.fixture(scope="module")
def vibration(coupled_vibration):
    return coupled_vibration("6chn25-34")


@pytest.fixture(scope="module")
def file(vibration):
    return vibration.engine_file.changed(strength=GIVEN)


@pytest.fixture(scope="module")
def stresses(file):
    """Coarse, of the throw with an oil hole across the pin at 30 degrees."""
    hole = cf.throws.OilHole(part="pin", diameter=0.018, angle=math.radians(30.0))
    with pytest.MonkeyPatch.context() as patched:
        stress_coarsely(patched)
        return fillet_stress.fillet_stresses(file.throw.changed(oil_holes=(hole,)), accuracy=0.2)


@pytest.fixture(scope="module")
def judge(vibration):
    loads = shaft_loads(vibration)

    def judged(stresses=None, throw=None, **section):
        own = vibration.engine_file.changed(strength=GIVEN | section)
        if throw is not None:
            own = own.changed(throw=throw)
        with pytest.MonkeyPatch.context() as patched:
            patched.setattr(engine_strength, "shaft_loads", lambda *_: loads)
            known = None if stresses is None else {"throw": stresses}
            return cf.strength.engine_strength(replace(vibration, engine_file=own), stresses=known)

    return judged


@pytest.mark.further
def test_factors_are_largest_stresses_over_nominal_ones(stresses, file):
    """Written out: W_eqw = 285 x 68^2 / 6 mm3, W_P = pi/16 D^3; middle of the web at 101.5 mm of 410 mm."""
    left, right = throw_webs(file.throw, file.strength)
    own = element_factors(stresses, (left, right))["left web"]
    peaks = {(one.load.kind, one.name): one for one in stresses.peaks}
    web, pin, journal = 0.285 * 0.068**2 / 6.0, "pin, left web", "left main journal"
    assert own.alpha_bending == close(peaks["bending", pin].von_mises * web)
    assert own.alpha_torsion == close(peaks["torsion", pin].shear * math.pi / 16.0 * 0.18**3)
    assert own.beta_bending == close(peaks["bending", journal].von_mises * web)
    assert own.beta_torsion == close(peaks["torsion", journal].shear * math.pi / 16.0 * 0.22**3)
    # Three-point bending: half of the force on each support, at L1 from the middle of the web.
    pressed = peaks["radial", journal].von_mises
    bending, shear = 0.5 * 0.1015 / web, 0.5 / (0.285 * 0.068)
    assert own.beta_combined == close(pressed / bending)
    assert own.beta_shear * shear + own.beta_bending * bending == close(pressed)
    # The rule's own factors of the peaks are the same, by the same nominal stresses.
    assert own.alpha_torsion == close(peaks["torsion", pin].rule_factor)
    assert own.error == stresses.error_estimate


@pytest.mark.further
def test_both_stand_side_by_side_and_the_smaller_formula_is_named(judge, stresses):
    found = judge(stresses)
    assert not found.by_elements
    own, formulas = found.throws[0].elements["left web"], found.throws[0].factors["left web"]
    web = found.to_record()["throws"][0]["webs"]["left web"]
    assert web["finite_elements"]["beta_torsion"] == own.beta_torsion
    assert web["factors"]["beta_torsion"] == formulas.beta_torsion
    table = factor_table(EngineStrength.from_json(found.to_json()))
    assert next(row[1] for row in table.rows) == "formulas"
    assert "finite elements" in [row[1] for row in table.rows]
    smaller = [
        name
        for name in ("alpha_bending", "alpha_torsion", "beta_bending", "beta_shear", "beta_torsion")
        if getattr(formulas, name) < getattr(own, name)
    ]
    said = " ".join(found.unsafe)
    more = 100.0 * (own.beta_torsion / formulas.beta_torsion - 1.0)
    assert f"beta_T (up to {more:.2g} %)" in found.warning
    assert "beta_Q" not in found.warning or "beta_shear" in smaller
    assert judge().warning == ""
    assert "beta_torsion" in smaller  # a journal thicker than the pin: see docs/stress.md
    for name, symbol in (("beta_torsion", "beta_T"), ("beta_shear", "beta_Q")):
        assert (f"{symbol} is {getattr(formulas, name):.3f} by the formula" in said) == (
            name in smaller
        )


@pytest.mark.slow
def test_finite_elements_count_if_the_file_says_so(judge, stresses):
    by_formula, found = judge(stresses), judge(stresses, factors="finite elements")
    assert found.by_elements
    for throw, other in zip(found.throws, by_formula.throws, strict=True):
        own = {one.place: one for one in throw.places}["pin fillet"]
        formula = {one.place: one for one in other.places}["pin fillet"]
        elements = throw.elements[own.web]
        assert own.bending == close(elements.alpha_bending * own.nominal_bending)
        assert own.torsion == close(elements.alpha_torsion * own.nominal_torsion)
        assert own.nominal_bending == close(formula.nominal_bending)
        assert own.strength == close(formula.strength)


@pytest.mark.slow
def test_cranks_outside_the_formulas_are_judged_by_finite_elements(judge, stresses):
    """The stresses are those of another web: only who judges is tested."""
    wide = {"web_width": 0.42}
    assert judge(stresses, throw=wide).left_out
    found = judge(stresses, throw=wide, factors="finite elements")
    assert found.left_out == ()
    assert found.passed is not None
    web = found.to_record()["throws"][0]["webs"]["left web"]
    assert web["factors"]["alpha_bending"] is None
    assert web["finite_elements"]["alpha_bending"] > 1.0


def test_what_is_not_meshed_has_no_factor():
    own = ElementFactors(web=None, **FACTORS)
    assert own.at("pin fillet") == (2.5, 0.0, 1.7)
    assert own.at("journal fillet") == (2.0, 2.1, 2.2)
    with pytest.raises(InputError, match=r"oil_holes: "):
        own.at("oil hole")


def test_nothing_is_unsafe_without_both():
    assert unsafe_formulas(None, ElementFactors(web=None, **FACTORS)) == {}


def test_the_shear_factor_is_less_certain_than_the_stresses_it_is_taken_from():
    """Of 2.4 and 2.0, 2 % each, what is left of the larger one is off by six times as much."""
    own = ElementFactors(web=None, **FACTORS)
    assert own.shear_error == close(0.12)
    assert replace(own, beta_combined=None).shear_error is None
    assert replace(own, beta_combined=own.beta_bending).shear_error == math.inf


def test_an_unsafe_shear_factor_names_its_method_and_its_error():
    web = cf.strength.CrankWeb(0.18, 0.22, 0.17, 0.068, 0.285, 0.012, 0.012)
    formulas = cf.strength.ConcentrationFactors(web)
    larger = 1.2 * formulas.beta_shear
    throw = engine_strength.ThrowStrength(
        number=1,
        places=(),
        webs={},
        factors={"left web": formulas},
        elements={"left web": ElementFactors(web, **FACTORS | {"beta_shear": larger})},
        torque=None,
        fit=None,
    )
    (said,) = [one for one in engine_strength.unsafe_sentences([throw]) if "beta_Q" in one]
    assert all(one in said for one in (f"{larger:.3f} ", "method 1, 20 %", "12 %"))
    assert "beta_Q (up to 20 %, method 1)" in engine_strength.unsafe_warning([throw])
