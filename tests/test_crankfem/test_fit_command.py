"""`crankfem fit` on a store whose results are calculated, not computed by finite elements."""

import sqlite3

import pytest

from comparing import close
from regression.models.compliance_model import ComplianceModel


def test_fit_prints_and_saves_a_model(store, call, tmp_path):
    answer = call("fit", store)
    assert answer.code == 0, answer.err
    text = " ".join(answer.out.split())
    for part in (
        "All responses",
        "log-cubic *",
        "Chosen by its errors: ",
        "Sobol, first",
        "Model: model.json",
    ):
        assert part in text
    model = ComplianceModel.load(tmp_path / "model.json")
    assert model.axial_compliance(web_width=0.31, web_thickness=0.06) == close(
        1e-9 * (0.2 + 0.3 / 0.31 * (0.05 / 0.06) ** 1.5), rel=5e-3
    )


def test_fit_takes_a_form_and_shows_a_response(store, call, tmp_path):
    answer = call("fit", store, "--form", "linear", "--response", "mass")
    assert answer.code == 0, answer.err
    text = " ".join(answer.out.split())
    assert "Mass m: largest (mean) errors" in text
    assert "linear: m = (" in text
    assert ComplianceModel.load(tmp_path / "model.json").responses["mass"].form == "linear"


def test_fit_takes_a_form_by_its_twin(store, call, tmp_path):
    """The compliance is made so that interactions lose their product, and the mass keeps it."""
    answer = call("fit", store, "--form", "interactions")
    assert answer.code == 0, answer.err
    assert "linear: e_n = " in " ".join(answer.out.split())
    model = ComplianceModel.load(tmp_path / "model.json")
    assert model.responses["axial_compliance"].form == "linear"
    assert model.responses["mass"].form == "interactions"


@pytest.mark.slow
def test_fit_writes_diagrams_and_json(store, call, tmp_path):
    answer = call("fit", store, "--plots", "diagrams", "--json", "--model", "other.json")
    assert answer.code == 0, answer.err
    record = answer.json()
    assert record["fits"]["mass"]["chosen"] in ("interactions", "quadratic")
    assert len(list((tmp_path / "diagrams").glob("axial_compliance_*.svg"))) == 4
    assert (tmp_path / "other.json").exists()


@pytest.mark.parametrize(
    ("option", "value", "message"),
    [
        ("--form", "cubic", "form: given 'cubic'; allowed are linear"),
        ("--response", "nothing", "response: given 'nothing'; allowed are axial_compliance, mass"),
        ("--model", "nowhere/model.json", "there is no folder nowhere"),
        ("--model", ".", "--model: given ., which is a folder; allowed is a file to write"),
    ],
)
def test_fit_refuses(store, call, tmp_path, option, value, message):
    answer = call("fit", store, option, value)
    assert (answer.code, answer.out) == (2, "")
    assert message in " ".join(answer.err.split())
    assert not (tmp_path / "model.json").exists()


@pytest.mark.parametrize("quiet", [(), ("-q",)])
def test_fit_tells_of_a_damaged_row_and_does_without(store, call, tmp_path, quiet):
    connection = sqlite3.connect(store)
    connection.execute("UPDATE designs SET responses = '{\"mass\": NaN}' WHERE rowid = 1")
    connection.commit()
    connection.close()
    answer = call("fit", store, *quiet)
    assert answer.code == 0, answer.err
    assert "1 row is damaged in" in " ".join(answer.err.split())
    assert ComplianceModel.load(tmp_path / "model.json").responses["mass"].runs == 11
