import math

import pytest

from comparing import close
from geometry.throw import CrankThrow
from regression.formulas.torsional_formulas import TORSIONAL_FORMULA_NAMES, torsional_formulas


def throw_of_mm(R, D_km, D_shm, L_km, L_shm, B, h):
    return CrankThrow(
        crank_radius=R / 1e3,
        main_journal_diameter=D_km / 1e3,
        pin_diameter=D_shm / 1e3,
        main_journal_length=L_km / 1e3,
        pin_length=L_shm / 1e3,
        web_width=B / 1e3,
        web_thickness=h / 1e3,
    )


MEDIUM_SPEED = throw_of_mm(170, 220, 180, 120, 139, 300, 68)

# Torsional compliance of plain throws without fillets, pure torque, by second-order tetrahedral
# finite elements [rad/(N m)].
FINITE_ELEMENTS = [
    ((170, 220, 180, 120, 139, 300, 50), 4.375e-8),
    ((170, 220, 180, 120, 139, 300, 68), 4.039e-8),
    ((170, 220, 180, 120, 139, 300, 90), 3.828e-8),
    ((130, 220, 190, 100, 130, 300, 60), 3.184e-8),
    ((130, 220, 190, 100, 130, 300, 90), 2.988e-8),
    ((70, 110, 88, 45, 80, 140, 27.5), 3.540e-7),
    ((90, 95, 85, 55, 70, 140, 25), 4.768e-7),
    ((775, 550, 550, 450, 400, 1050, 320), 1.794e-9),
]
RANGE = {
    "Carter": (0.94, 1.03),
    "Ker Wilson": (1.02, 1.10),
    "Geiger": (0.93, 0.99),
    "Timoshenko (free)": (1.03, 1.23),
    "Zimanenko": (1.05, 1.25),
}


@pytest.mark.parametrize(("dimensions", "compliance"), FINITE_ELEMENTS)
def test_ratio_to_finite_elements(dimensions, compliance):
    for name, value in torsional_formulas(throw_of_mm(*dimensions)).items():
        low, high = RANGE[name]
        assert low - 0.005 <= value.value / compliance <= high + 0.005, name


def test_values_by_hand():
    E, G = 2.1e11, 2.1e11 / 2.6
    R, D, d, L, l, B, h = 0.17, 0.22, 0.18, 0.12, 0.139, 0.3, 0.068  # noqa: E741
    stiff, beams = 32 / (math.pi * G), 2 * R / (E * h * B**3 / 12)
    expected = {
        "Carter": stiff * ((L + 0.8 * h) / D**4 + 0.75 * l / d**4 + 1.5 * R / (h * B**3)),
        "Ker Wilson": stiff
        * ((L + 0.4 * D) / D**4 + (l + 0.4 * d) / d**4 + (R - 0.2 * (D + d)) / (h * B**3)),
        "Geiger": stiff * ((L + 0.4 * h) / D**4 + (l + 0.4 * h) / d**4) + beams,
        "Timoshenko (free)": stiff * ((L + 0.9 * h) / D**4 + (l + 0.9 * h) / d**4) + beams,
        "Zimanenko": stiff
        * (
            (L + 0.6 * h * D / L) / D**4
            + (0.8 * l + 0.2 * B / R * D) / d**4
            + R * math.sqrt(R / d) / (h * B**3)
        ),
    }
    found = {name: value.value for name, value in torsional_formulas(MEDIUM_SPEED).items()}
    assert found == close(expected, rel=1e-12)


def test_names_units_and_sources():
    values = torsional_formulas(MEDIUM_SPEED)
    assert tuple(values) == TORSIONAL_FORMULA_NAMES
    for value in values.values():
        assert value.unit == "rad/(N m)"
        assert value.valid
        assert "textbook formula quoted from the general literature" in value.source


def test_all_lengths_doubled_divide_by_eight():
    double = throw_of_mm(340, 440, 360, 240, 278, 600, 136)
    for name, value in torsional_formulas(double).items():
        plain = torsional_formulas(MEDIUM_SPEED)[name].value
        assert value.value == close(plain / 8.0, rel=1e-12), name


def test_ker_wilson_without_a_web_left_is_refused():
    short = throw_of_mm(70, 200, 180, 100, 100, 250, 40)
    values = torsional_formulas(short)
    assert not values["Ker Wilson"].valid
    assert values["Carter"].valid


def test_zimanenko_says_what_the_other_diameter_gives():
    G = 2.1e11 / 2.6
    value = torsional_formulas(MEDIUM_SPEED)["Zimanenko"]
    change = 32 / (math.pi * G) * 0.2 * 300 / 170 * (0.22 - 0.18) / 0.18**4
    other = f"{(value.value - change) * 1e9:.4g}e-9 rad/(N m)"
    assert any(other in remark for remark in value.remarks)
    equal = torsional_formulas(throw_of_mm(170, 200, 200, 120, 139, 300, 68))["Zimanenko"]
    assert not any("Reprints" in remark for remark in equal.remarks)
