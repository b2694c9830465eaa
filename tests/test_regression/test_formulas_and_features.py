import math

import pytest

from comparing import close
from geometry.throw import CrankThrow
from geometry.throw_dimensions import FurtherPin, Web
from regression.formulas.axial_formulas import axial_formulas
from regression.formulas.case import round_area, round_inertia
from regression.formulas.torsional_formulas import torsional_formulas


def test_sections_with_bores():
    assert round_inertia(0.2, 0.0) == close(math.pi / 64.0 * 0.2**4)
    # A thin ring: I = pi D^3 t / 8, area pi D t.
    assert round_inertia(0.2, 0.1999) == close(math.pi * 0.19995**3 * 5e-5 / 8.0, rel=1e-5)
    assert round_area(0.2, 0.1999) == close(math.pi * 0.19995 * 5e-5, rel=1e-9)


@pytest.mark.parametrize("formulas", [axial_formulas, torsional_formulas])
def test_bores_make_every_formula_softer_by_what_they_take(dimensions, formulas):
    plain = formulas(CrankThrow(**dimensions))
    bored = formulas(CrankThrow(**dimensions, pin_bore=0.09, main_journal_bore=0.11))
    for name, value in bored.items():
        if name == "TsNIIMF":  # the webs alone
            assert value.value == plain[name].value
            assert any("ignores the bores" in remark for remark in value.remarks)
            continue
        # Half the diameter takes 1/16 of the inertia and a quarter of the area.
        assert plain[name].value < value.value < 4.0 / 3.0 * plain[name].value


@pytest.mark.parametrize(("formulas", "power"), [(axial_formulas, 1), (torsional_formulas, 3)])
def test_every_formula_keeps_its_dimensionless_value_at_another_size(dimensions, formulas, power):
    """e E D and e_t E D^3 do not change with the size."""
    larger = formulas(CrankThrow(**{name: 1.7 * value for name, value in dimensions.items()}))
    for name, value in formulas(CrankThrow(**dimensions)).items():
        assert larger[name].value * 1.7**power == close(value.value, rel=1e-12)


def test_what_a_formula_does_not_know_is_said(dimensions):
    several = CrankThrow(**dimensions, further_pins=(FurtherPin(angle=math.pi),))
    for formulas in (axial_formulas, torsional_formulas):
        for value in formulas(several).values():
            assert not value.valid
            assert any("several pins" in remark for remark in value.remarks)
        unequal = formulas(CrankThrow(**dimensions, right_web=Web(thickness=0.09)))
        assert all(any("webs differ" in text for text in v.remarks) for v in unequal.values())
        thin = formulas(CrankThrow(**dimensions, web_tip_thickness=0.05))
        assert all(any("tapered" in text for text in v.remarks) for v in thin.values())
