"""Diagrams, tables and grids of studies, equations, models and formulas, on a made-up power law."""

from dataclasses import replace

import numpy as np
import pytest
from matplotlib import pyplot

from comparing import close
from crankbase.errors import InputError
from geometry.throw import CrankThrow
from refusals import refused
from regression.fits.fits import fit_form
from regression.formulas.axial_formulas import axial_formulas
from regression.formulas.case import formulas_to_pandas
from regression.models.compliance_model import ComplianceModel
from regression.models.response_model import ResponseModel
from regression.optimum import Limit, LimitCheck, Optimum
from regression.plans.factors import Factor
from regression.plans.plan import StudyPlan
from regression.plots import draw_formula_bars, factor_text, term_text
from regression.runs.study_table import StudyTable

WIDTHS, THICKNESSES = np.array([0.27, 0.30, 0.33]), np.array([0.05, 0.07, 0.09])
RUNS = np.array([(width, thickness) for width in WIDTHS for thickness in THICKNESSES])
NAMES = ("web_width", "web_thickness")


def compliance(x):
    return 1.2e-9 * (x[..., 0] / 0.3) ** -0.8 * (x[..., 1] / 0.07) ** -1.2


@pytest.fixture(scope="module")
def fit():
    held = np.array([[0.28, 0.06], [0.32, 0.08]])
    # An error of 1 % that the form cannot follow, so that standard errors are above zero.
    off = 1.0 + 0.01 * np.cos(7.0 * np.arange(len(RUNS)))
    return fit_form("power law", NAMES, RUNS, compliance(RUNS) * off, held, compliance(held))


@pytest.fixture(scope="module")
def model(fit):
    response = ResponseModel.from_fit(fit, symbol="e_n", unit="m/N", support="pinned")
    return ComplianceModel(responses={"axial_compliance": response}, fixed={"pin_length": 0.139})


@pytest.fixture(scope="module")
def table(dimensions):
    outline = Factor.of_labels("web_outline", ("obround", "rectangle"))
    factors = (Factor("web_width", "m", 0.27, 0.33), outline)
    return StudyTable(
        plan=StudyPlan(CrankThrow(**dimensions), factors),
        values=np.array([[0.27, 0.0], [0.30, 1.0], [0.33, 0.0]]),
        held_out=np.array([False, True, False]),
        responses={"axial_compliance_pinned": np.array([1.3e-9, 1.2e-9, 1.1e-9])},
        errors={"axial_compliance_pinned": np.full(3, 0.01)},
        dimensions={},
        outlines={},
        seconds=np.ones(3),
        failures=(),
    )


def test_a_study_in_dots(table):
    axes = table.plot()
    fitted, held = axes.lines
    assert fitted.get_xdata() == close([270.0, 330.0])
    assert fitted.get_ydata() == close([1.3, 1.1])
    assert held.get_ydata() == close([1.2])
    assert axes.get_xlabel() == "web width $B$ [mm]"
    assert axes.get_ylabel() == r"$e_{\mathrm{n}}$ [$10^{-9}$ m/N]"
    choices = table.plot(factor="web_outline").get_xticklabels()
    assert [text.get_text() for text in choices] == ["obround", "rectangle"]
    for option in ("response", "factor"):
        with pytest.raises(InputError, match=f"{option}: given 'height'; allowed are .*, because"):
            table.plot(**{option: "height"})


def test_a_study_as_a_table(table):
    frame = table.to_pandas()
    assert frame["held_out"].tolist() == [False, True, False]
    assert frame["web_outline"].tolist() == ["obround", "rectangle", "obround"]
    assert frame["axial_compliance_pinned"].tolist() == [1.3e-9, 1.2e-9, 1.1e-9]
    units = frame.attrs["units"]
    assert (units["web_width"], units["axial_compliance_pinned"]) == ("m", "m/N")
    assert units["axial_compliance_pinned error"] == "1"


def test_effects_of_a_fit(fit):
    axes = fit.plot()
    widths = [bar.get_width() for bar in axes.patches]
    coded = fit.coded_coefficients
    assert widths == close(
        [100.0 * abs(coded["ln(web_thickness)"]), 100.0 * abs(coded["ln(web_width)"])]
    )
    assert [text.get_text() for text in axes.get_yticklabels()] == ["ln($h$)", "ln($B$)"]
    assert axes.get_xlabel().endswith("[%]")


def test_a_fit_as_a_table(fit):
    frame = fit.to_pandas().set_index("term")
    assert frame["coefficient"].to_dict() == fit.coefficients
    assert frame["coded_coefficient"].to_dict() == fit.coded_coefficients
    assert frame["standard_error"].to_dict() == fit.natural_standard_errors
    few = RUNS[[0, 1, 3]]  # as many as coefficients
    assert "standard_error" not in fit_form("power law", NAMES, few, compliance(few)).to_pandas()


def test_a_model_over_one_factor(model):
    axes = model.plot(over="web_thickness", web_width=0.29)
    (line,) = axes.lines
    x = line.get_xdata() * 1e-3
    assert (x[0], x[-1]) == close((0.05, 0.09))
    assert line.get_ydata() == close(model.axial_compliance(web_width=0.29, web_thickness=x) * 1e9)
    band = axes.collections[0].get_paths()[0].vertices[:, 1]
    lowest = model.lookup("axial_compliance", web_width=0.29, web_thickness=0.09).lower
    assert band.min() == close(lowest * 1e9)
    assert axes.get_legend().get_title().get_text() == "web width 290 mm"
    with refused("over"):
        model.plot(over="mass")
    for swept, given in (("web_width", {"web_width": 0.31}), ("gamma_deg", {"gamma_deg": 60.0})):
        with pytest.raises(InputError, match=f"{swept}: given .* with 'over={swept}'; allowed is"):
            model.plot(over=swept, **given)


def test_a_model_beyond_its_range_says_so(model):
    axes = model.plot(over="web_thickness", web_width=0.4)
    assert axes.lines[-1].get_label() == "outside the range of the fit"
    assert not axes.collections  # no band holds there


def test_a_model_as_table_and_grid(model):
    frame = model.to_pandas()
    assert frame["unit"].tolist() == ["m/N"]
    assert frame["largest_heldout_error"][0] == (
        model.responses["axial_compliance"].largest_heldout_error
    )
    found = model.to_xarray(points=3)
    assert found.axial_compliance.dims == NAMES
    assert found.axial_compliance.sel(web_width=0.33, web_thickness=0.05).item() == close(
        model.axial_compliance(web_width=0.33, web_thickness=0.05)
    )
    along = model.to_xarray("axial_compliance", web_width=[0.28, 0.29])
    assert along.axial_compliance.dims == ("web_width",)
    assert along.attrs["web_thickness"] == close(0.07)
    assert along.web_width.attrs["units"] == "m"
    with refused("points"):
        model.to_xarray(points=2000)
    for wrong in (-1, 0, 1, 1.5, None, True):
        with refused("points"):
            model.to_xarray(points=wrong)


@pytest.fixture
def optimum(model):
    limit = Limit(("axial_compliance",), at_most=1.5e-9, unit="m/N")
    lookup = model.lookup("axial_compliance", web_width=0.3, web_thickness=0.06)
    return Optimum(
        minimized="web_thickness",
        value=0.06,
        unit="m",
        dimensions={"web_width": 0.3, "web_thickness": 0.06, "pin_length": 0.139},
        factors={"web_width": 0.3, "web_thickness": 0.06},
        limits=(LimitCheck(limit, 1.44e-9, 1.5e-9, True),),
        at_ends=(),
        lookups={"axial_compliance": lookup},
        throw=None,
        remarks=(),
        evaluations=1,
    )


def test_an_optimum(optimum):
    axes = optimum.plot()
    assert [bar.get_height() for bar in axes.patches] == close([96.0, 100.0])
    assert axes.get_ylabel() == "share of the bound [%]"
    frame = optimum.to_pandas().set_index("name")
    assert frame["kind"].to_dict() == {
        "web_width": "factor",
        "web_thickness": "factor",
        "pin_length": "dimension",
        "axial_compliance": "response",
    }
    assert frame.loc["axial_compliance", "value"] == optimum.lookups["axial_compliance"].value
    with refused("limits"):
        replace(optimum, limits=()).plot()


def test_formulas_as_a_table_and_as_bars(dimensions):
    found = axial_formulas(CrankThrow(**dimensions), gamma_deg=180)
    frame = formulas_to_pandas(found)
    assert dict(zip(frame["formula"], frame["value"], strict=True)) == {
        name: one.value for name, one in found.items()
    }
    assert frame.attrs["units"]["value"] == "m/N"
    axes = pyplot.figure().add_subplot()
    draw_formula_bars(axes, ["one", "two"], np.array([1.0, 2.0]), [True, False], "e [1]", 1.5)
    assert [bar.get_width() for bar in axes.patches] == [1.0, 2.0]
    assert len({bar.get_facecolor() for bar in axes.patches}) == 2
    assert axes.lines[0].get_xdata()[0] == 1.5
    alone = pyplot.figure().add_subplot()
    draw_formula_bars(alone, ["one"], np.array([1.0]), [True], "e [1]", None)
    assert [text.get_text() for text in alone.get_legend().texts] == ["applies to the throw"]
    assert not alone.lines


def test_words_for_people():
    assert factor_text("web_width") == "web width $B$"
    assert factor_text("overlap_ratio") == "overlap ratio"
    assert term_text("ln(L_shm)^2 overlap_ratio") == r"ln($L_{\mathrm{shm}}$)^2 overlap ratio"
