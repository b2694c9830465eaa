"""A saved compliance model as the source of an engine's compliances: in its file, and by --model."""

import json

import pytest

from comparing import close
from crankfem.jobs.run_computation import read_inputs
from fitted_models import known_model

VALUES = {"axial_compliance": 1.3e-9, "torsional_compliance": 4.1e-8}


@pytest.fixture
def silent(six_cylinders, edit):
    """The shipped six without gas pressure, of which only modes are calculated."""
    return edit(six_cylinders, {"[gas]": None})


@pytest.fixture
def saved(tmp_path, coarse_throw):
    """Save a model of some responses, and its throw's coarse analysis."""
    engine, analysis = coarse_throw("6chn25-34")

    def save(*responses):
        values = {name: VALUES[name] for name in responses or VALUES}
        path = tmp_path / "model.json"
        known_model(engine.throw, engine.material, values, 0.05).save(path)
        return analysis

    return save


def written(tmp_path, text, name="mine.toml"):
    (tmp_path / name).write_text(text, encoding="utf-8")
    return name


@pytest.mark.slow
def test_a_model_in_the_file_and_by_option_give_the_same(
    coarsely, silent, saved, edit, call, tmp_path
):
    analysis = saved()
    sources = {f"vibration.{kind}_source": '"regression"' for kind in ("axial", "torsional")}
    own = edit(silent, sources | {"vibration.model": '"model.json"'})
    by_file = call("vibration", written(tmp_path, own), "--json")
    assert by_file.code == 0, by_file.err
    plain = written(tmp_path, silent, "plain.toml")
    by_option = call("vibration", plain, "--model", "model.json", "--json").json()
    without = call("vibration", plain, "--json").json()
    for kind, value in (("axial", 1.3e-9), ("torsional", 4.1e-8)):
        record = by_file.json()[kind]
        assert record["source"] == by_option[kind]["source"] == "regression"
        assert record["modes"] == by_option[kind]["modes"]
        # At the place of each throw in the shaft as by finite elements, from another pinned value.
        means = {one["source"]: one["mean_compliance"] for one in record["sources"]}
        pinned = getattr(analysis, f"{kind}_compliance")("pinned")
        assert means["regression"] == close(means["fe"] * value / pinned)
        assert without[kind]["source"] == "fe"


def test_an_option_takes_what_the_model_holds(saved, call, silent, tmp_path):
    saved("torsional_compliance")
    name = written(tmp_path, silent)
    vibration = read_inputs(name, tmp_path / "model.json").engine_file.vibration
    assert (vibration.axial_source, vibration.torsional_source) == ("fe", "regression")
    for command in ("vibration", "run"):
        answer = call(command, name, "--model", "nowhere.json")
        assert answer.code == 2
        assert answer.err.startswith("Error: --model: nowhere.json: cannot be read")


def test_the_study_gives_way_and_the_model_is_told(saved, silent, tmp_path):
    saved()
    inputs = read_inputs(written(tmp_path, silent), tmp_path / "model.json")
    assert inputs.engine_file.study is not None
    assert inputs.study is None
    assert inputs.option == "model.json"
    assert inputs.paths[-1].name == inputs.files[-1]["name"] == "model.json"
    told = {one.field: one.source for one in inputs.engine_file.records}
    assert told["vibration.model"] == told["vibration.axial_source"] == "option --model"
    alone = read_inputs(tmp_path / "mine.toml")
    assert (alone.study, alone.model, alone.option) == (alone.engine_file.study, None, None)


WRONG = {
    "no such file": (
        {"vibration.model": '"nowhere.json"'},
        "vibration.model: given 'nowhere.json', which is not in the folder of mine.toml",
    ),
    "no model": ({"vibration.model": '"mine.toml"'}, "is a TOML file"),
    "another throw": (
        {"throw.pin_length": '"150 mm"'},
        "given 'regression', which does not apply to this throw: pin_length: given 150 mm",
    ),
    "outside the range": (
        {"throw.web_thickness": '"95 mm"'},
        "which does not apply to this throw: web_thickness: given 95 mm; the range of the fit is 45 mm "
        "to 90 mm",
    ),
    "no such response": (
        {"vibration.axial_source": '"regression"'},
        "vibration.axial_source: given 'regression', which does not apply to this throw: the model has "
        "torsional_compliance"
        " and no axial_compliance",
    ),
}


@pytest.mark.parametrize(("changes", "said"), WRONG.values(), ids=WRONG)
@pytest.mark.parametrize("command", ["check", "vibration", "run"])
def test_what_vibration_refuses_is_refused_at_once(
    saved, silent, edit, call, tmp_path, command, changes, said
):
    saved("torsional_compliance")
    named = {"vibration.torsional_source": '"regression"', "vibration.model": '"model.json"'}
    answer = call(command, written(tmp_path, edit(silent, named | changes)))
    assert (answer.code, answer.out) == (2, "")
    assert said in answer.err
    assert "Traceback" not in answer.err


def test_a_model_given_by_option_is_refused_by_its_option(saved, silent, edit, call, tmp_path):
    saved()
    thick = written(tmp_path, edit(silent, {"throw.web_thickness": '"95 mm"'}))
    for command in ("vibration", "run"):
        answer = call(command, thick, "--model", "model.json")
        assert answer.code == 2
        assert answer.err.startswith(
            "Error: --model: given model.json, which does not apply to this throw: web_thickness:"
        )


def test_check_tells_which_command_fits(silent, saved, edit, call, tmp_path):
    text = edit(silent, {"vibration.axial_source": '"regression"'})
    name = written(tmp_path, text)
    record = call("check", name, "--json").json()
    assert "vibration" not in record["commands"]
    assert "class" not in record["commands"]
    assert any("crankfem run fits" in one for one in record["remarks"])
    answer = call("vibration", name)
    assert answer.code == 2
    assert "given 'regression' without a fitted model" in answer.err
    saved()
    record = call(
        "check", written(tmp_path, edit(text, {"vibration.model": '"model.json"'})), "--json"
    ).json()
    assert "vibration" in record["commands"]
    assert "class" not in record["commands"]  # without gas pressure
    assert "class" in call("check", "6chn25-34", "--json").json()["commands"]
    assert any("the section [study] is not run" in one for one in record["remarks"])
    thick = edit(text, {"throw.web_thickness": '"99 mm"'})
    answer = call("check", written(tmp_path, thick))
    assert answer.code == 2
    assert "the throw that its study varies: web_thickness: given 99 mm" in answer.err


@pytest.mark.further
def test_a_run_with_a_saved_model(coarsely, silent, saved, call, tmp_path):
    saved()
    answer = call("run", written(tmp_path, silent), "--model", "model.json", "--output", "out")
    assert answer.code == 0, answer.err
    assert "The study is not run" in answer.err
    found = json.loads((tmp_path / "out" / "results.json").read_text(encoding="utf-8"))
    own = found["formulas"]["regression"]["axial"]
    assert (own["value"], own["of"]) == (close(1.3e-9), "the saved model model.json")
    assert own["remarks"][-1].startswith("The section [study] was not run")
    assert found["study"] is None
    assert found["repeat"]["command"] == "crankfem run mine.toml --model model.json"
    assert "regression of the saved model model.json" in (
        tmp_path / "out" / "report.html"
    ).read_text(encoding="utf-8")
