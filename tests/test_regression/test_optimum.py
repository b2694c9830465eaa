"""Optima against brute force on a grid, exact optima of simple equations, and refusals.

A grid of m points between the ends of a range finds no better value than the search, and comes within
one step of it: the tolerance of the grid tests is that step.
"""

import itertools
import re

import numpy as np
import pytest

from comparing import close
from crankbase.errors import InputError
from regression.fits.fits import fit_form
from regression.models.compliance_model import ComplianceModel
from regression.models.response_model import ResponseModel
from regression.optimum import Limit, Points, find_optimum, worst_values

BOX = {"web_width": (0.270, 0.330), "web_thickness": (0.038, 0.098), "pin_length": (0.120, 0.158)}
FIXED = {
    "crank_radius": 0.170,
    "main_journal_diameter": 0.220,
    "pin_diameter": 0.180,
    "main_journal_length": 0.120,
    "fillet_radius": 0.012,
}
THROW = {**FIXED, "web_width": 0.300, "web_thickness": 0.068, "pin_length": 0.139}


def grid(box, levels):
    return np.array(list(itertools.product(*(np.linspace(*ends, levels) for ends in box.values()))))


def axial(x):
    width, thickness, length = x.T
    return 1.4e-9 * (width / 0.3) ** -0.8 * (thickness / 0.07) ** -1.2 * (length / 0.14) ** 0.4


def mass(x):
    width, thickness, length = x.T
    return 7850.0 * (2.0 * width * thickness * 0.35 + 0.025 * (length + 0.12))


def response(form, function, symbol, unit, box=BOX, **others):
    x = grid(box, 3)
    held = np.array([np.mean(ends) for ends in box.values()])[None] * [[1.01], [0.98]]
    fit = fit_form(form, tuple(box), x, function(x), held, function(held))
    return ResponseModel.from_fit(fit, symbol=symbol, unit=unit, **others)


@pytest.fixture(scope="module")
def model():
    return ComplianceModel(
        responses={
            "axial_compliance": response("log-quadratic", axial, "e_n", "m/N", fe_error=0.01),
            "mass": response("quadratic", mass, "m", "kg", fe_error=1e-4),
        },
        fixed=FIXED,
        ranges=BOX,
        throw=THROW,
    )


def test_lightest_throw_against_a_grid(model):
    limit = Limit(("axial_compliance",), at_most=1.1e-9, unit="m/N")
    found = find_optimum(model, "mass", [limit])
    points = 41
    x = grid(BOX, points)
    rows = Points(model, dict(zip(BOX, x.T, strict=True)))
    weights = rows.band("mass")[0]
    kept = worst_values(limit, rows, margins=True) <= 1.1e-9
    assert 0 < kept.sum() < len(x)
    best = weights[kept].min()
    assert found.value <= best * (1.0 + 1e-9)
    # One step of the grid in each dimension at the optimum changes the mass by this at most.
    steps = [np.ptp(ends) / (points - 1) for ends in BOX.values()]
    at = np.array([[found.factors[name] for name in BOX]])
    change = sum(
        float(mass(at + np.eye(3)[n] * step)[0] - mass(at)[0]) for n, step in enumerate(steps)
    )
    assert best - found.value <= change
    (check,) = found.limits
    assert check.active
    assert check.worst <= 1.1e-9
    assert check.worst == close(1.1e-9, rel=1e-6)
    assert found.lookups["axial_compliance"].upper == close(check.worst, rel=1e-12)
    assert all(answer.inside for answer in found.lookups.values())
    assert found.throw.web_thickness == found.factors["web_thickness"]
    assert re.fullmatch(
        r"Optimum\(mass [\d.]+ kg at web_width 0.\d+, web_thickness 0.\d+, pin_length 0.\d+, "
        r"at the limit of axial_compliance\)",
        repr(found),
    )


def test_a_frequency_as_a_function_of_the_compliance(model):
    # A mass of 500 kg on the throw's stiffness: f = sqrt(1 / (m e)) / (2 pi).
    def frequency(compliance):
        return (1.0 / (500.0 * compliance)) ** 0.5 / (2.0 * np.pi)

    limit = Limit(("axial_compliance",), at_least=200.0, function=frequency, name="f", unit="Hz")
    found = find_optimum(model, "web_thickness", [limit])
    needed = 1.0 / (500.0 * (2.0 * np.pi * 200.0) ** 2)
    same = find_optimum(
        model, "web_thickness", [Limit(("axial_compliance",), at_most=needed, name="e")]
    )
    assert found.value == close(same.value, rel=1e-6)
    assert found.limits[0].worst == close(200.0, rel=1e-6)
    assert found.limits[0].value > found.limits[0].worst


def test_categories_are_tried_each():
    x = np.array([[h, label] for h in np.linspace(0.04, 0.10, 5) for label in (0.0, 1.0)])

    def stiff(x):
        return 1e-9 * (x[:, 0] / 0.07) ** -1.0 * (1.0 - 0.1 * x[:, 1])

    fit = fit_form("log-quadratic", ("web_thickness", "web_outline=rectangle"), x, stiff(x))
    model = ComplianceModel(
        responses={"axial_compliance": ResponseModel.from_fit(fit, symbol="e_n", unit="m/N")},
        ranges={"web_thickness": (0.04, 0.10)},
        categories={"web_outline": ("obround", "rectangle")},
    )
    limit = Limit(("axial_compliance",), at_most=1e-9)
    found = find_optimum(model, "web_thickness", [limit], margins=False)
    assert found.factors["web_outline"] == "rectangle"
    assert found.value == close(0.063, rel=1e-6)
    obround = find_optimum(
        model, "web_thickness", [limit], margins=False, fixed={"web_outline": "obround"}
    )
    assert obround.value == close(0.070, rel=1e-6)


def test_relations_and_constraints_are_kept():
    x = np.linspace(1.2, 1.9, 5)[:, None]
    box = {"width_ratio": (1.2, 1.9), "web_thickness": (0.04, 0.10)}

    def stiff(x):
        return 1e-9 / (x[:, 0] / 1.6) / (x[:, 1] / 0.07)

    x = grid(box, 4)
    fit = fit_form("log-quadratic", tuple(box), x, stiff(x))
    model = ComplianceModel(
        responses={
            "axial_compliance": ResponseModel.from_fit(
                fit, symbol="e_n", unit="m/N", lowest={}, equation="e"
            )
        },
        fixed=FIXED | {"pin_length": 0.139},
        ranges=box,
        relations={"web_width": "width_ratio * pin_diameter"},
        constraints=("web_width <= 4 * web_thickness",),
        throw=THROW,
    )
    limit = Limit(("axial_compliance",), at_most=1e-9)
    found = find_optimum(model, "web_thickness", [limit], margins=False)
    # The wide web that the compliance alone would take breaks the constraint: B = 4 h and
    # B h = 1.6 D 0.07 meet at h^2 = 0.4 D 0.07.
    assert found.value == close((0.4 * 0.18 * 0.07) ** 0.5, rel=1e-6)
    assert found.dimensions["web_width"] == close(4.0 * found.value, rel=1e-6)
    assert found.throw.web_width == found.dimensions["web_width"]
    narrow = find_optimum(model, "web_width", [limit], margins=False)
    assert narrow.value == close(1.2 * 0.18, rel=1e-9)


def test_a_throw_that_cannot_be_built_is_told():
    box = {"web_width": (0.150, 0.330)}
    made = response("quadratic", lambda x: 1e-9 * (2.0 - x[:, 0]), "e_n", "m/N", box)
    model = ComplianceModel(
        responses={"axial_compliance": made}, ranges=box, throw=THROW | {"web_width": 0.3}
    )
    found = find_optimum(model, "web_width")
    assert found.value == 0.150
    assert found.throw is None
    assert found.remarks[0].startswith("this throw cannot be built: throw.")


def test_what_cannot_be_kept_is_told_with_how_near_one_comes(model):
    impossible = Limit(("axial_compliance",), at_most=0.5e-9, unit="m/N")
    with pytest.raises(InputError) as caught:
        find_optimum(model, "mass", [impossible])
    text = str(caught.value)
    assert text.startswith("limits: given ones that no throw of the model's family keeps")
    stiffest = {"web_width": 0.330, "web_thickness": 0.098, "pin_length": 0.120}
    nearest = model.lookup("axial_compliance", **stiffest).upper
    assert f"axial_compliance <= 0.5e-9 m/N comes to {1e9 * nearest:.6g}e-9 m/N" in text
    assert "web_width 330 mm, web_thickness 98 mm, pin_length 120 mm" in text
    assert "\n" not in text


def test_two_limits_against_each_other(model):
    limits = [Limit(("axial_compliance",), at_most=0.9e-9), Limit(("mass",), at_most=120.0)]
    with pytest.raises(InputError, match=r"axial_compliance <= .*; mass <= "):
        find_optimum(model, "web_thickness", limits)


@pytest.mark.parametrize(
    ("arguments", "match"),
    [
        (
            ("color", []),
            "minimize: given 'color'; allowed are the responses axial_compliance, mass",
        ),
        (("mass", [Limit(("hue",), at_most=1.0)]), "quantity: given 'hue'"),
    ],
)
def test_unknown_names(model, arguments, match):
    with pytest.raises(InputError, match=match):
        find_optimum(model, *arguments)


@pytest.mark.parametrize(
    ("fixed", "match"),
    [
        ({"crank_radius": 0.17}, "fixed: given crank_radius; allowed are the factors web_width"),
        ({"web_width": 0.4}, "fixed: given 400 mm for web_width; allowed is 270 mm to 330 mm"),
        ({"color": 0.4}, "color: unknown dimension"),
    ],
)
def test_unusable_fixed_factors(model, fixed, match):
    with pytest.raises(InputError, match=match):
        find_optimum(model, "mass", [], fixed=fixed)


@pytest.mark.parametrize(
    ("arguments", "match"),
    [
        ({"quantities": ("mass",)}, "given at most None, at least None"),
        ({"quantities": ("mass",), "at_most": 1.0, "at_least": 0.0}, "one finite bound"),
        ({"quantities": ("mass",), "at_most": float("nan")}, "one finite bound"),
        ({"quantities": (), "at_most": 1.0}, "at least one"),
        ({"quantities": "mass", "at_most": 1.0}, "allowed is a tuple of names"),
        ({"quantities": ("mass", "web_width"), "at_most": 1.0}, "given 2 quantities"),
    ],
)
def test_unusable_limits(arguments, match):
    with pytest.raises(InputError, match=match):
        Limit(**arguments)


def test_a_function_without_a_value_is_refused(model):
    limit = Limit(("mass",), at_most=1.0, function=lambda _: float("nan"), name="f")
    with pytest.raises(InputError, match="f: given a function that returns nan"):
        find_optimum(model, "mass", [limit])
