"""Two models on the same throws: equations whose differences are known in closed form."""

import numpy as np
import pytest

from comparing import close
from crankbase.errors import InputError
from crankfem.analyses.study import model_comparison
from crankfem.analyses.study.fitting import fit_study
from crankfem.analyses.study.model_comparison import compare_models
from crankfem.analyses.study.study_model import compliance_model
from geometry.throw import CrankThrow
from plans import table_of_function
from regression.plans.design_choice import DesignChoice
from regression.plans.factors import Factor
from regression.plans.plan import StudyPlan

THROW = CrankThrow(
    crank_radius=0.170,
    main_journal_diameter=0.220,
    pin_diameter=0.180,
    main_journal_length=0.120,
    pin_length=0.140,
    web_width=0.300,
    web_thickness=0.068,
    fillet_radius=0.012,
)


def model(scale=1.0, widths=(0.27, 0.33), lengths=(0.12, 0.16), bend=0.0, throw=THROW, **others):
    """A power law of width and length, times a scale and 1 + bend (2 B / 60 mm - 10)."""

    def law(x):
        off = 1.0 + bend * (x[:, 0] - 0.30) / 0.03
        return scale * off * 1e-9 * (x[:, 0] / 0.3) ** -1.5 * (x[:, -1] / 0.14) ** 0.5

    factors = [Factor.spread("web_width", "m", *widths, 5, "even")]
    if lengths is not None:
        factors.append(Factor.spread("pin_length", "m", *lengths, 5, "even"))

    def of_factors(x):
        return law(np.column_stack([x[:, 0], x[:, 1] if lengths else np.full(len(x), 0.14)]))

    plan = StudyPlan(throw, tuple(factors), **others)
    table = table_of_function(plan, of_factors)
    return compliance_model(table, fit_study(table))


@pytest.fixture(autouse=True)
def few_throws(monkeypatch):
    monkeypatch.setattr(model_comparison, "THROWS", 64)


@pytest.fixture(scope="module")
def base():
    return model()


def test_a_scale_is_the_difference_everywhere(base):
    found = compare_models(base, model(1.02))
    (one,) = found.responses
    assert (one.response, one.unit) == ("axial_compliance", "m/N")
    # Power laws are fitted to round-off.
    assert [one.mean, one.rms, one.largest] == close([0.02, 0.02, 0.02], rel=1e-6)
    assert one.second == close(1.02 * one.first, rel=1e-6)
    # Finite elements are off by half a percent, either way: of the first and smaller value the band reaches
    # up by that, of the second, which is larger by 2 %, down.
    assert one.by_bands == close(0.02 / (0.005 + 1.02 * 0.005), rel=1e-3)
    assert one.apart == 1.0
    frame = found.to_pandas()
    assert frame["largest"].tolist() == [one.largest]
    back = compare_models(model(1.02), base).responses[0]
    assert back.largest == close(1 / 1.02 - 1, rel=1e-6)
    assert back.by_bands == close(one.by_bands, rel=1e-6)


def test_the_largest_difference_is_told_with_its_place(base):
    found = compare_models(base, model(bend=0.03))
    (one,) = found.responses
    # The fits of the other law, a straight line times a power, are good to some parts in 1e5.
    assert abs(one.largest) == close(0.03, abs=2e-4)
    assert one.place["web_width"] == close(0.33 if one.largest > 0 else 0.27, rel=1e-9)
    # Half of the points lie between the ends, so the mean square is less than (0.03)^2 and more than a third.
    assert 0.03 / np.sqrt(3.0) < one.rms < 0.03
    assert one.mean == close(0.0, abs=1e-3)
    assert 0.0 < one.apart < 1.0


def test_only_the_common_range_is_asked_for(base):
    found = compare_models(base, model(1.01, widths=(0.31, 0.36)))
    assert found.ranges["web_width"] == (0.31, 0.33)
    assert found.throws > 32  # all but those outside a range of dimensionless groups
    fixed = model(1.01, lengths=None)
    for pair in ((base, fixed), (fixed, base)):
        met = compare_models(*pair)
        assert 32 < met.throws < 64  # those at the two ends of the width count once
        assert met.ranges.get("pin_length", (0.14, 0.14)) == (0.14, 0.14)
        assert abs(met.responses[0].largest) == close(0.01, rel=0.02)


def test_a_model_of_an_older_release_is_told(base):
    response = base.responses["axial_compliance"].model_copy(update={"too_small": True})
    old = base.model_copy(update={"responses": {"axial_compliance": response}})
    assert compare_models(base, base).remarks == compare_models(old, old).remarks == ()
    for pair, which in (((base, old), "second"), ((old, base), "first")):
        (remark,) = compare_models(*pair).remarks
        assert remark.startswith(
            f"The {which} model was fitted to finite elements of an older release, not"
        )


def test_constraints_of_either_are_kept(base):
    narrow = model(constraints=("web_width > 160 mm + pin_length",))
    for pair in ((base, narrow), (narrow, base)):
        found = compare_models(*pair)
        assert 0 < found.throws < 60
        place = found.responses[0].place
        assert place["web_width"] >= 0.160 + place["pin_length"] - 1e-9


@pytest.mark.slow
def test_models_of_the_same_throws_in_other_factors(base):
    ratios = StudyPlan(
        THROW,
        (Factor("width_ratio", "", 1.5, 1.8),),
        DesignChoice("latin hypercube", runs=12),
        relations={"web_width": "width_ratio * pin_diameter"},
    )
    table = table_of_function(ratios, lambda x: 1e-9 * (x[:, 0] * 0.18 / 0.3) ** -1.5)
    other = compliance_model(table, fit_study(table))
    for pair in ((base, other), (other, base)):
        if pair[0] is base:
            # Of a length of the pin that varies, the other model knows one value.
            assert "width_ratio" not in compare_models(*pair).ranges
        one = compare_models(*pair).responses[0]
        assert one.largest == close(0.0, abs=1e-6)


@pytest.mark.parametrize(
    ("others", "message"),
    [
        (
            {"widths": (0.34, 0.36)},
            r"^web_width: given 270 mm to 330 mm in one model and 340 mm to",
        ),
        (
            {"throw": THROW.model_copy(update={"pin_diameter": 0.17})},
            r"^models: given two that have no throw in common \(s/R: ",
        ),
    ],
)
def test_models_that_have_nothing_in_common(base, others, message):
    with pytest.raises(InputError, match=message):
        compare_models(base, model(**others))


def test_the_command(base, call, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    base.save("a.json")
    model(bend=0.03).save("b.json")
    answer = call("compare", "a.json", "b.json")
    assert answer.code == 0, answer.err
    text = " ".join(answer.out.split())
    assert (
        " throws in the ranges of both models: web_width 270 mm to 330 mm, pin_length 120 mm to 160"
        in text
    )
    assert "Largest difference, of axial compliance: at web_width" in text
    record = call("compare", "a.json", "b.json", "--json").json()
    assert record["responses"][0]["response"] == "axial_compliance"
    assert record["left_out"] == {}
    same = call("compare", "a.json", "a.json", "--json").json()["responses"][0]
    assert (same["rms"], same["by_bands"], same["apart"]) == (0.0, 0.0, 0.0)
    refused = call("compare", "a.json", "none.json")
    assert refused.code == 2
    assert "none.json" in refused.err
