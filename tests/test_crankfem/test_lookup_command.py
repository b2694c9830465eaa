"""Commands and engines that ask a compliance model or the law."""

import json
import sys

import numpy as np
import pytest
import typer

from comparing import close
from crankbase.errors import InputError
from crankfem.analyses.shaft.sources import (
    axial_sources,
    compliances_in_shaft,
    law_values,
    refuse_law,
    source_spread,
    torsional_sources,
)
from crankfem.analyses.throw.law_record import LawResults, law_answers, law_results
from crankfem.cli.arguments import law_throw
from crankfem.cli.commands.lookup import lookup
from crankfem.files.engine.engine_file import load_engine
from crankfem.files.engine.throw_file import load_throw
from crankfem.files.reading.data_files import input_path
from crankfem.jobs.run_computation import read_inputs
from fem.analysis import analyze_throw
from fem.angle_law import AngleLaw
from fem.material import STEEL
from fitted_models import SIZES, THROW, known_model, made_model
from geometry.throw import CrankThrow
from regression.fits.fits import fit_form
from regression.law.throw_law import axial_law, torsional_law
from regression.models.compliance_model import ComplianceModel
from regression.models.response_model import ResponseModel
from regression.response_kinds import GUIDED_MOMENTS
from stand_ins import caller_of
from throws import MEDIUM_SPEED

ENGINE = "6chn25-34"


@pytest.fixture
def path(tmp_path):
    made_model().save(tmp_path / "m.json")
    return tmp_path / "m.json"


# What a lookup needs nothing of.
HEAVY = ("scipy", "skfem", "fem.solver", "geometry.mesh", "dynamics", "matplotlib", "pint")


@pytest.mark.slow
@pytest.mark.parametrize(
    "asked",
    [
        ("m.json", "web_width=285mm", "web_thickness=68mm"),
        ("m.json", "--throw", ENGINE, "--gamma", "120 deg"),
        ("law", "--throw", ENGINE),
    ],
    ids=["dimensions", "throw", "law"],
)
def test_a_lookup_loads_nothing_heavy(spawn, path, asked):
    code = (
        "import sys; from crankfem.cli.entry import main; main(); "
        f"print([n for n in {HEAVY} if n in sys.modules])"
    )
    command = [sys.executable, "-c", code, "lookup"]
    answer = spawn(*asked, command=command, folder=path.parent)
    assert answer.out.splitlines()[-1] == "[]", answer.err


@pytest.mark.slow
def test_a_lookup_by_dimensions_loads_few_modules(spawn, path):
    ours = ("crankfem", "crankbase", "regression", "dynamics", "fem", "geometry")
    code = (
        "import sys; from crankfem.cli.entry import main; main(); "
        f"print(sum(n.partition('.')[0] in {ours} for n in sys.modules))"
    )
    command = [sys.executable, "-c", code, "lookup"]
    asked = ("m.json", "web_width=285mm", "web_thickness=68mm")
    answer = spawn(*asked, command=command, folder=path.parent)
    assert int(answer.out.splitlines()[-1]) <= 60, answer.err


@pytest.fixture
def run():
    app = typer.Typer()
    app.command()(lookup)
    app.callback()(lambda: None)
    return caller_of(app)


# ------------------------------------------------------------------------------------------ lookup

PAIRS = ("web_width=300mm", "web_thickness=68 mm")


def test_values_with_bands(run, path):
    out = run("lookup", path, *PAIRS)
    lines = out.splitlines()
    lower, upper = 1.3 / 1.005 * 0.99, 1.3 / 0.995 * 1.01
    rows = [line.split() for line in lines[-len(SIZES) :]]
    assert [
        "axial",
        "compliance",
        "pinned",
        "1.3e-9",
        f"{lower:.4g}e-9",
        f"{upper:.4g}e-9",
        "m/N",
    ] in rows
    assert ["mass", "pinned", "100"] in [row[:3] for row in rows]


@pytest.mark.slow
def test_a_throw_of_another_material(run, tmp_path):
    """The model answers what finite elements give for that material; another Poisson's ratio is refused."""
    iron = STEEL.changed(youngs_modulus=1.65e11)
    known = {m: analyze_throw(THROW, m, 0.1).axial_compliance() for m in (STEEL, iron)}
    known_model(THROW, STEEL, {"axial_compliance": known[STEEL]}, 0.01).save(tmp_path / "m.json")
    text = input_path(ENGINE).read_text(encoding="utf-8")
    file = tmp_path / "iron.toml"
    file.write_text(text.replace("210 GPa", "165 GPa"), encoding="utf-8")
    found = json.loads(run("lookup", tmp_path / "m.json", "--throw", file, "--json"))
    assert found["axial_compliance"]["value"] == close(known[iron], rel=1e-6)
    file.write_text(text.replace("value = 0.3,", "value = 0.29,"), encoding="utf-8")
    with pytest.raises(InputError, match=r"^material\.poisson_ratio: "):
        run("lookup", tmp_path / "m.json", "--throw", file)


def test_json_has_all(run, path):
    found = json.loads(run("lookup", path, *PAIRS, "--json"))
    model = ComplianceModel.load(path)
    assert set(found) == {*SIZES, "units"}
    answer = model.lookup("mass", web_width=0.3, web_thickness=0.068)
    assert found["mass"] == {
        "value": answer.value,
        "lower": answer.lower,
        "upper": answer.upper,
        "unit": "kg",
        "symbol": "m",
        "support": "pinned",
        "inside": True,
        "remarks": [],
        "largest_held_out_error": 0.005,
        "largest_fe_error_estimate": 0.01,
        "band": answer.band,
        "equation": answer.equation,
    }


def test_gamma(run, path):
    found = json.loads(run("lookup", path, *PAIRS, "--gamma", "120", "--json"))
    model = ComplianceModel.load(path)
    expected = model.axial_compliance(gamma_deg=120.0, web_width=0.3, web_thickness=0.068)
    assert found["axial_compliance"]["value"] == close(expected, rel=1e-14)
    assert found["axial_compliance"]["support"] == "between neighbors at 120 deg"
    assert found["mass"]["support"] == "pinned"


def test_bands_tell_what_is_not_known(run, path):
    model = ComplianceModel.load(path)
    unknown = {
        "band_error": None,
        "largest_heldout_error": None,
        "largest_fe_error": None,
        "largest_error": 0.03,
    }
    mass = ResponseModel(**(model.responses["mass"].model_dump() | unknown))
    ComplianceModel(**(model.model_dump() | {"responses": {**model.responses, "mass": mass}})).save(
        path
    )
    assert "(0.5 % to 3 %)" in run("lookup", path, *PAIRS, "--full")
    found = json.loads(run("lookup", path, *PAIRS, "--json"))["mass"]
    assert found["largest_held_out_error"] is found["largest_fe_error_estimate"] is None


def test_gamma_without_its_numbers(run, path):
    model = ComplianceModel.load(path)
    bare = ComplianceModel(responses={"axial_compliance": model.responses["axial_compliance"]})
    bare.save(path)
    with pytest.raises(InputError, match="axial_compliance_in_line"):
        run("lookup", path, *PAIRS, "--gamma", "120")
    ComplianceModel(responses={"mass": model.responses["mass"]}).save(path)
    with pytest.raises(InputError, match=r"^--gamma: "):
        run("lookup", path, *PAIRS, "--gamma", "120")


def test_outside_and_strict(run, path):
    outside = ("web_width=345mm", "web_thickness=68mm")
    found = json.loads(run("lookup", path, *outside, "--json"))["mass"]
    assert (found["lower"], found["upper"]) == (None, None)
    with pytest.raises(InputError, match=r"^web_width: given 345 mm"):
        run("lookup", path, *outside, "--strict")


def test_choices_and_free_factors_on_the_command_line(run, path):
    columns = ("width_ratio", "web_outline=rectangle")
    x = np.array([[r, label] for r in (1.4, 1.6, 1.8) for label in (0.0, 1.0)])
    fit = fit_form("power law", columns, x, 1e-9 * (1.0 + x[:, 1]) / x[:, 0])
    ComplianceModel(
        responses={"axial_compliance": ResponseModel.from_fit(fit, symbol="e_n", unit="m/N")},
        ranges={"width_ratio": (1.4, 1.8)},
        units={"width_ratio": ""},
        categories={"web_outline": ("obround", "rectangle")},
    ).save(path)
    out = run("lookup", path, "width_ratio=1.6", "web_outline=rectangle", "--json")
    assert json.loads(out)["axial_compliance"]["value"] == close(1.25e-9, rel=1e-9)
    with pytest.raises(InputError, match=r"^web_outline: "):
        run("lookup", path, "width_ratio=1.6", "web_outline=round")
    with pytest.raises(InputError, match=r"^width_ratio: "):
        run("lookup", path, "width_ratio=1.6 mm", "web_outline=obround")


def test_a_response_that_cannot_be_told_is_left_out(run, path):
    from fem.material import STEEL

    model = ComplianceModel.load(path)
    x = np.linspace(1.4, 1.9, 4)[:, None]
    fit = fit_form("power law", ("B/D_shm",), x, 60.0 / x[:, 0])
    groups = ResponseModel.from_fit(fit, symbol="e_n", unit="m/N", basis="groups")
    ComplianceModel(
        **(
            model.model_dump()
            | {
                "responses": {"axial_compliance": groups, "mass": model.responses["mass"]},
                "fixed": {"pin_diameter": 0.18},
                "material": STEEL.model_dump(),
            }
        )
    ).save(path)
    pairs = ("web_width=600mm", "web_thickness=136mm", "pin_diameter=360mm")
    assert "refused" in json.loads(run("lookup", path, *pairs, "--json"))["mass"]
    with pytest.raises(InputError, match="pin_diameter: given 360 mm"):
        run("lookup", path, *pairs, "--strict")


REACTIONS = {
    "axial_reaction": (0.46, -0.1, "P/Z", ""),
    "axial_reaction_guided": (0.2, 0.1, "P/Z", ""),
}
GUIDED = {name: (0.13, 0.1, name, "") for name in GUIDED_MOMENTS}


@pytest.fixture
def reaction_path(tmp_path, monkeypatch):
    """A model that knows reactions of pinned and guided ends, but none of neighbors."""
    for name, size in (REACTIONS | GUIDED).items():
        monkeypatch.setitem(SIZES, name, size)
    made_model().save(tmp_path / "reactions.json")
    return tmp_path / "reactions.json"


def test_reactions_to_a_pin_force(run, reaction_path):
    model = ComplianceModel.load(reaction_path)
    wanted = model.reactions((0.0, -1e5, 0.0), web_width=0.3, web_thickness=0.068)
    found = json.loads(run("lookup", reaction_path, *PAIRS, "--pin-force", "100 kN", "--json"))
    assert found["reactions"]["pin_force"] == [0.0, -1e5, 0.0]
    pinned = found["reactions"]["supports"]["pinned"]
    assert pinned["reactions"]["left"]["force"] == wanted.left.force.tolist()
    assert pinned["band"]["right"]["force"] == wanted.band.right.force.tolist()
    units = {path.rpartition(".")[2]: unit for path, unit in found["units"].items()}
    assert (units["force"], units["moment"]) == ("N", "N m")
    assert GUIDED_MOMENTS[0] in found


def test_reactions_outside_the_range(run, reaction_path):
    outside = ("web_width=345mm", "web_thickness=68mm", "--pin-force", "40, -100, 0 kN")
    found = json.loads(run("lookup", reaction_path, *outside, "--json"))
    assert found["reactions"]["supports"]["guided"]["band"]["left"]["force"] == [None] * 3
    with pytest.raises(InputError, match=r"^web_width: given 345 mm"):
        run("lookup", reaction_path, *outside, "--strict")


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
        assert answer.err.startswith("Error: --model: nowhere.json: ")


def test_the_study_gives_way_and_the_model_is_told(saved, silent, tmp_path):
    saved()
    inputs = read_inputs(written(tmp_path, silent), tmp_path / "model.json")
    assert inputs.engine_file.study is not None
    assert inputs.study is None
    assert inputs.option == "model.json"
    assert inputs.paths[-1].name == inputs.files[-1].name == "model.json"
    told = {one.field: one.source for one in inputs.engine_file.records}
    assert told["vibration.model"] == told["vibration.axial_source"] == "option --model"
    alone = read_inputs(tmp_path / "mine.toml")
    assert (alone.study, alone.model, alone.option) == (alone.engine_file.study, None, None)


@pytest.mark.parametrize(
    ("changes", "field"),
    [
        ({"vibration.model": '"nowhere.json"'}, "vibration.model"),
        ({"vibration.model": '"mine.toml"'}, "vibration.model"),
        ({"throw.pin_length": '"150 mm"'}, "vibration.torsional_source"),
        ({"throw.web_thickness": '"95 mm"'}, "vibration.torsional_source"),
        ({"vibration.axial_source": '"regression"'}, "vibration.axial_source"),
    ],
)
@pytest.mark.parametrize("command", ["check", "vibration", "run"])
def test_what_vibration_refuses_is_refused_at_once(
    saved, silent, edit, call, tmp_path, command, changes, field
):
    saved("torsional_compliance")
    named = {"vibration.torsional_source": '"regression"', "vibration.model": '"model.json"'}
    answer = call(command, written(tmp_path, edit(silent, named | changes)))
    assert (answer.code, answer.out) == (2, "")
    assert answer.err.lstrip().startswith(f"Error: {field}: ")


def test_a_model_given_by_option_is_refused_by_its_option(saved, silent, edit, call, tmp_path):
    saved()
    thick = written(tmp_path, edit(silent, {"throw.web_thickness": '"95 mm"'}))
    for command in ("vibration", "run"):
        answer = call(command, thick, "--model", "model.json")
        assert answer.code == 2
        assert answer.err.startswith("Error: --model: given model.json")


@pytest.mark.slow
def test_check_tells_which_command_fits(silent, saved, edit, call, tmp_path):
    text = edit(silent, {"vibration.axial_source": '"regression"'})
    name = written(tmp_path, text)
    record = call("check", name, "--json").json()
    assert "vibration" not in record["commands"]
    answer = call("vibration", name)
    assert answer.code == 2
    assert answer.err.lstrip().startswith("Error: vibration.axial_source: ")
    saved()
    record = call(
        "check", written(tmp_path, edit(text, {"vibration.model": '"model.json"'})), "--json"
    ).json()
    assert "vibration" in record["commands"]
    answer = call("check", written(tmp_path, edit(text, {"throw.web_thickness": '"99 mm"'})))
    assert answer.code == 2
    assert "web_thickness: given 99 mm" in answer.err


@pytest.mark.further
def test_a_run_with_a_saved_model(coarsely, silent, saved, call, tmp_path):
    saved()
    answer = call("run", written(tmp_path, silent), "--model", "model.json", "--output", "out")
    assert answer.code == 0, answer.err
    found = json.loads((tmp_path / "out" / "results.json").read_text(encoding="utf-8"))
    own = found["formulas"]["regression"]["axial"]
    assert own["value"] == close(1.3e-9)
    assert found["study"] is None
    assert found["repeat"]["command"] == "crankfem run mine.toml --model model.json"


PLAIN = MEDIUM_SPEED | {"web_width": 0.3}
LAW_THROW = CrankThrow(**PLAIN)
OUTSIDE = CrankThrow(**PLAIN | {"crank_radius": 0.480})
LAW_PAIRS = [f"{name}={1e3 * value:g} mm" for name, value in PLAIN.items()]
# Covered by the plain tier of the law; its throw has bores of none and obround webs.


def test_answers_are_the_laws_with_their_bands():
    found, law = (
        law_answers(LAW_THROW, STEEL),
        axial_law(LAW_THROW, youngs_modulus=STEEL.youngs_modulus),
    )
    own = found["axial_compliance"]
    assert (own.lower, own.upper) == close(law.band)
    assert own.value == law.pinned
    assert found["torsional_compliance_guided"].value == close(
        torsional_law(LAW_THROW, youngs_modulus=STEEL.youngs_modulus).guided
    )
    assert {one.unit for one in found.values()} == {"m/N", "rad/(N m)", ""}


def test_between_neighbors_the_band_is_that_of_all_three_numbers():
    found, law = law_answers(LAW_THROW, STEEL, 240.0), axial_law(LAW_THROW, youngs_modulus=2.1e11)
    numbers = (law.guided, law.pinned, law.ratio, law.influence_guided, law.influence_pinned)
    expected = float(AngleLaw(*numbers).axial(120.0))
    own = found["axial_compliance"]
    assert own.value == close(expected * 2.1e11 / STEEL.youngs_modulus, rel=1e-12)
    assert own.lower < own.value < own.upper
    assert own.support == "between neighbors at 240 deg"
    # Wider than that of either end by itself, for rho has a band too.
    assert own.upper / own.value > found["axial_compliance_guided"].upper / law.guided * (
        STEEL.youngs_modulus / 2.1e11
    )


def test_the_sentence_tells_value_and_band_or_the_ratio_outside():
    found = law_results(LAW_THROW, STEEL)
    own = found.answers["axial_compliance"]
    width = 100.0 * (own.upper / own.value - 1.0)
    sentence = found.sentence()
    assert f"e_n {1e9 * own.value:.4g}e-9 m/N within {width:.2g} %" in sentence
    assert LawResults.from_json(found.to_json()).sentence() == sentence
    refused = law_results(OUTSIDE, STEEL)
    assert refused.answers is None
    assert "crank_radius" in refused.reason or "plain" in refused.reason


def test_a_throw_of_pairs_or_of_an_engine_that_they_change():
    assert law_throw(LAW_PAIRS) == (LAW_THROW, STEEL)
    throw, material = load_throw(ENGINE)
    assert law_throw(["web_width=310mm"], ENGINE) == (throw.changed(web_width=0.310), material)


# --------------------------------------------------------------------------- source of an engine


@pytest.fixture(scope="module")
def engine():
    return load_engine(input_path(ENGINE))


@pytest.fixture(scope="module")
def analysis(engine):
    return analyze_throw(engine.throw, engine.material, 0.1)


def test_the_law_as_a_source_is_its_pinned_value_times_the_throws_ratios(engine, analysis):
    shaft = compliances_in_shaft(engine, analysis)
    for kind, sources in (("axial", axial_sources), ("torsional", torsional_sources)):
        values, _ = sources(engine, analysis, shaft, None)["law"]
        pinned = getattr(analysis, f"{kind}_compliance")("pinned")
        own = law_values(engine, f"{kind}_compliance")[engine.throw]
        assert values == close(own.value * getattr(shaft, kind) / pinned, rel=1e-12)
        spread = source_spread(engine, kind, "law", analysis, shaft, None)
        assert (spread.low, spread.high) == close((own.lower / own.value, own.upper / own.value))


@pytest.mark.slow
def test_engines_whose_throws_the_law_does_not_cover_refuse_it(tmp_path, call):
    text = input_path(ENGINE).read_text(encoding="utf-8")
    path = tmp_path / "long.toml"
    path.write_text(text.replace('axial_source = "fe"', 'axial_source = "law"'), encoding="utf-8")
    refuse_law(load_engine(path))
    assert call("check", path).code == 0
    bored = text.replace('axial_source = "fe"', 'axial_source = "law"').replace(
        "[throw]", '[[throw.oil_holes]]\npart = "pin"\ndiameter = "20 mm"\n\n[throw]'
    )
    path.write_text(bored, encoding="utf-8")
    with pytest.raises(InputError, match=r"^vibration\.axial_source: "):
        refuse_law(load_engine(path))
