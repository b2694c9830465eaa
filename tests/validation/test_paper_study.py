"""The paper's regression repeated, and a family of engines.

Source: Yamanin, Zhukov 2021, doi 10.24143/2073-1574-2021-4-75-83: fit of e_n for a 25/34 throw; own designs
held out. Verifies the regression, not the finite elements.

Tolerance: 27 runs 2.5 % (measured 1.9), at most 40 runs 0.5 % (0.12), the engine left out 5 % (0.1).

Vestnik AGTU, Morskaya tekhnika, 2021 no. 4, pp. 75-83:
``e = 1e-10 (6.1 - 0.0583 B - 0.0386 h + 0.0102 L_shm)`` for B 270 ... 330, h 38 ... 98, L_shm 120 ... 158 mm,
without units of the variables. Finite element results are this program's (tests/golden, README.md there).
Q2 of the linear form is 0.87 within 0.01.
"""

import csv
from pathlib import Path

import numpy as np
import pytest

from comparing import close
from fem.material import STEEL
from fem.responses import evaluate_throw
from geometry.throw import CrankThrow
from regression.fits.fits import fit_form
from regression.fits.forms import FORMS, code, design_matrix, group_names, group_values
from regression.fits.selection import choose
from regression.response_kinds import response_scale

GOLDEN = Path(__file__).parents[1] / "golden"
FACTORS = ("web_width", "web_thickness", "pin_length")
MAIN = (
    "crank_radius",
    "main_journal_diameter",
    "pin_diameter",
    "main_journal_length",
    "pin_length",
    "web_width",
    "web_thickness",
    "fillet_radius",
)
FACTOR_FORMS = [name for name, form in FORMS.items() if form.basis == "factors"]
# What the paper does not vary, as benchmarks/paper_study.py has it.
REST = dict(zip(MAIN[:4], (0.170, 0.220, 0.180, 0.135), strict=True)) | {"fillet_radius": 0.012}


def rows_of(name):
    with (GOLDEN / name).open(encoding="utf-8") as file:
        return list(csv.DictReader(file))


def paper(role):
    rows = [row for row in rows_of("paper_study.csv") if role in row["role"].split("+")]
    x = np.array([[float(row[name]) for name in FACTORS] for row in rows])
    return x, np.array([float(row["axial_compliance_pinned"]) for row in rows])


def scatter():
    rows = rows_of("paper_study.csv")
    return float(np.std([float(row["axial_compliance_pinned_error"]) for row in rows]))


def best(role):
    x, y = paper(role)
    fits = [
        fit_form(form, FACTORS, x, y, *paper("held out"), drop_terms=True) for form in FACTOR_FORMS
    ]
    return fits[choose(fits, scatter()).place]


def test_held_out_designs_are_thirty_and_inside():
    x, _ = paper("held out")
    assert len(x) == 30
    assert np.all((x >= [0.270, 0.038, 0.120]) & (x <= [0.330, 0.098, 0.158]))
    assert len(paper("27")[0]) == 27
    assert len(paper("36")[0]) == 36


def test_factorial_of_27_runs(figure):
    found = best("27")
    assert found.fitted.logarithmic
    worst = found.largest_heldout_error
    figure("27 runs: largest error of 30 held-out designs", worst, 0.0, 0.025, "", "absolute")
    # The quadratic form has the largest Q2 but for rounding, and the larger error between the levels.
    quadratic = fit_form("quadratic", FACTORS, *paper("27"), *paper("held out"))
    assert quadratic.q_squared > 0.9999
    assert quadratic.largest_error < 0.005
    assert quadratic.largest_heldout_error > 0.05


def test_36_runs_with_four_levels_of_the_thickness(figure):
    found = best("36")
    assert found.form == "log-cubic"
    worst = found.largest_heldout_error
    figure("36 runs: largest error of 30 held-out designs", worst, 0.0, 0.005, "", "absolute")


def test_linear_form_and_the_printed_one(figure):
    x, y = paper("27")
    linear = fit_form("linear", FACTORS, x, y)
    figure("Q2 of the linear form", linear.q_squared, 0.87, 0.01, "", "absolute")
    # In 1e-10 m/N and mm; the printed ones beside it: 6.1, -0.0583, -0.0386, 0.0102.
    constant, width, thickness, length = linear.fitted.natural_coefficients(
        [1e-3] * 3, 1e-10
    ).values()
    assert constant == close(36, rel=0.05)
    assert width < 0.0 < length
    # The thickness does 8 times as much as printed: 0.2965.
    assert -0.32 < thickness < -0.28


def printed(x):
    return 1e-10 * (6.1 - 0.0583 * x[:, 0] - 0.0386 * x[:, 1] + 0.0102 * x[:, 2])


def test_printed_form_in_three_readings():
    x, y = paper("27")
    in_mm = printed(1e3 * x)
    assert in_mm.max() < 0.0  # no compliance
    in_cm = printed(1e2 * x)
    centered = printed(1e3 * (x - [0.300, 0.068, 0.139]))
    coded = printed((x - [0.300, 0.068, 0.139]) / [0.030, 0.030, 0.019])
    # The ranges that the documentation states, in 1e-10 m/N.
    for reading, lowest, highest in (
        (in_mm, -15.7, -9.5), (in_cm, 3.9, 4.5), (centered, 3.0, 9.2), (coded, 6.0, 6.2)
    ):  # fmt: skip
        assert 1e10 * reading.min() == close(lowest, abs=0.06)
        assert 1e10 * reading.max() == close(highest, abs=0.06)
    for reading in (in_cm, centered):
        assert np.all(reading < 0.94e-9)
        assert np.max(np.abs(reading / y - 1.0)) > 0.6
    # Nowhere does it see what h does: a factor of 3, against at most 1.5 printed.
    middle = np.isclose(x[:, 0], 0.300) & np.isclose(x[:, 2], 0.139)
    assert np.ptp(np.log(y[middle])) > np.log(2.5)
    for reading in (in_cm, centered):
        assert np.ptp(np.log(reading[middle])) < np.log(1.5)


def family(role):
    rows = [row for row in rows_of("engine_family.csv") if row["role"] == role]
    dimensions = {name: np.array([float(row[name]) for row in rows]) for name in MAIN}
    names = group_names(MAIN)
    x = np.column_stack([group_values(dimensions)[name] for name in names])
    return names, x, dimensions, rows


@pytest.mark.slow
@pytest.mark.parametrize(
    ("response", "unit", "held_out_within", "engine_within"),
    [
        # The engine's bound is the one asked for; the held-out ones are what is measured (1.4, 0.3,
        # 0.5 %) rounded up, so that a worse choice of groups shows.
        ("axial_compliance_pinned", "m/N", 0.02, 0.05),
        ("torsional_compliance_pinned", "rad/(N m)", 0.005, 0.05),
        ("mass", "kg", 0.008, 0.05),
    ],
)
def test_engine_left_out_of_its_family(response, unit, held_out_within, engine_within, figure):
    names, x, dimensions, rows = family("run")
    _, held_x, held_dimensions, held_rows = family("held out")
    _, engine_x, engine_dimensions, engine = family("6chn18-22")
    y, held_y, engine_y = (
        np.array([float(row[response]) for row in some]) for some in (rows, held_rows, engine)
    )
    found = fit_form(
        "group quadratic",
        names,
        x,
        y,
        held_x,
        held_y,
        scale=response_scale(unit, dimensions, STEEL),
        heldout_scale=response_scale(unit, held_dimensions, STEEL),
        drop_terms=True,
    )
    worst, name = found.largest_heldout_error, response.replace("_", " ")
    figure(f"family, held-out designs: {name}", worst, 0.0, held_out_within, "", "absolute")
    predicted = response_scale(unit, engine_dimensions, STEEL) * found.predict(engine_x)
    figure(f"engine left out: {name}", predicted, engine_y, engine_within, unit)


def test_coding_of_the_study_is_well_conditioned():
    found = best("36")
    coded = code(
        paper("36")[0], found.fitted.center, found.fitted.half_range, found.fitted.log_factors
    )
    assert np.linalg.cond(design_matrix(found.fitted.terms, coded)) < 20.0


@pytest.mark.slow
@pytest.mark.parametrize("place", [0, 40, 70])
def test_golden_numbers_are_what_finite_elements_give(place, figure):
    row = rows_of("paper_study.csv")[place]
    throw = CrankThrow(**REST, **{name: float(row[name]) for name in FACTORS})
    found = evaluate_throw(throw, STEEL, 0.01).values
    for column, unit in (
        ("axial_compliance_pinned", "m/N"),
        ("torsional_compliance_pinned", "rad/(N m)"),
    ):
        what = f"recomputed: {column.replace('_', ' ')}"
        figure(what, found[column], float(row[column]), 2e-3, unit)
