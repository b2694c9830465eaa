"""Numbers that no float holds, given to the functions of Python: refused in a sentence."""

import pytest

from crankbase.checks.arrays import finite_array, positive_number
from crankbase.checks.scalars import whole_number
from crankbase.errors import InputError
from dynamics.indices import values_at_nodes
from dynamics.turning.speed_over_angle import checked_inertia
from fem.material import STEEL
from fem.modes import free_modes
from fem.supports import Neighbors
from geometry.throw import CrankThrow
from regression.formulas.axial_formulas import axial_formula
from regression.law.throw_law import axial_law
from regression.plans.factors import Factor

THROW = CrankThrow(
    crank_radius=0.170,
    main_journal_diameter=0.220,
    pin_diameter=0.180,
    main_journal_length=0.135,
    pin_length=0.139,
    web_width=0.285,
    web_thickness=0.068,
)


@pytest.mark.parametrize("number", [10**400, -(10**400), 10**5000], ids=["large", "low", "endless"])
@pytest.mark.parametrize(
    "call",
    [
        lambda number: Neighbors(number, 0.0),
        lambda number: free_modes(None, STEEL, highest_frequency=number),
        lambda number: axial_law(THROW, youngs_modulus=number),
        lambda number: axial_formula("Anderson", THROW, gamma_deg=number),
        lambda number: THROW.changed(crank_radius=number),
        lambda number: positive_number("field", number, "s", "time runs"),
        lambda number: whole_number("field", number, 1, "they are counted"),
        lambda number: values_at_nodes("field", {0: number}, 3, "kg", "it is a mass"),
        lambda number: finite_array("field", [1.0, number]),
        lambda number: checked_inertia(number, 0.0),
        lambda number: Factor("web_width", "m", 0.1, number),
    ],
    ids=[
        "support",
        "modes",
        "formula",
        "angle",
        "throw",
        "positive",
        "whole",
        "nodes",
        "array",
        "inertia",
        "factor",
    ],
)
def test_numbers_too_large_for_a_float_are_refused_everywhere(call, number):
    with pytest.raises(InputError):
        call(number)
