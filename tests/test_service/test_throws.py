import time

import pytest

from comparing import close
from crankbase.errors import InputError
from crankfem import (
    STEEL,
    CrankThrow,
    Neighbors,
    analyze_throw,
    axial_formulas,
    axial_law,
    load_throw,
    torsional_law,
)
from crankfem.analyses.throw.law_record import law_answers
from crankfem.client import Client, RefusedError
from crankfem.formulas import law_reactions


@pytest.fixture
def client(service):
    return Client(service.address)


def test_a_throw_in_numbers_and_in_texts_is_the_same(client, throw):
    texts = {name: f"{1000.0 * value:g} mm" for name, value in throw.items()}
    found, same = client.validate(throw), client.validate(texts)
    assert found.dimensions == same.dimensions == throw
    assert found.shape.length == close(CrankThrow(**throw).length)
    assert client.outline(throw) == client.outline(texts)


def test_the_file_of_a_throw_says_the_same(client, throw, tmp_path):
    given = throw | {
        "web_outline": "rectangle",
        "left_web": {"thickness": 0.07},
        "counterweight": {"outer_radius": 0.3, "angle": 1.5},
    }
    file = tmp_path / "mine.toml"
    file.write_text(client.validate(given).toml)
    read = client.check_file(file)
    assert read.kind == "throw"
    assert load_throw(file) == (
        CrankThrow.from_text(
            {
                **{name: f"{value!r} m" for name, value in throw.items()},
                "web_outline": "rectangle",
                "left_web": {"thickness": "0.07 m"},
                "counterweight": {"outer_radius": "0.3 m", "angle": "1.5 rad"},
            }
        ),
        STEEL,
    )


def test_formulas_are_those_of_the_library(client, throw):
    found = client.formulas(throw, gamma_deg=120.0)
    known = axial_formulas(CrankThrow(**throw), 120.0)
    assert {one.name: one.value for one in found.axial} == {n: v.value for n, v in known.items()}


def test_the_law_answers_with_bands_and_reactions(client, throw):
    force = (2e4, -2e5, 0.0)
    asked = {"gamma_deg": 120.0, "pin_force": force, "support": "neighbors"}
    found = client.law(throw, **asked)
    axial, torsional = axial_law(CrankThrow(**throw)), torsional_law(CrankThrow(**throw))
    assert found.values["axial_compliance_pinned"].value == close(axial.pinned)
    assert found.values["axial_compliance_pinned"].lower == close(axial.band[0])
    assert found.values["axial_compliance_neighbors"].value == close(float(axial.axial(120.0)))
    between = law_answers(CrankThrow(**throw), STEEL, 120.0)["axial_compliance"]
    assert found.values["axial_compliance_neighbors"].upper == close(between["upper"])
    assert found.values["torsional_compliance_guided"].value == close(torsional.guided)
    known = law_reactions(CrankThrow(**throw), force, Neighbors(120.0, 120.0))
    assert found.reactions.left.force == close(known.left.force.tolist())
    assert found.reactions.right.moment == close(known.right.moment.tolist())
    assert found.reactions.left.force_band[2] == close(known.band.left.force[2])
    assert client.law(throw).reactions is None
    unequal = client.law(throw, **asked, left_gamma_deg=240.0).reactions
    known = law_reactions(CrankThrow(**throw), force, Neighbors(240.0, 120.0))
    assert unequal.right.moment == close(known.right.moment.tolist())
    assert unequal.right.moment[0] != close(found.reactions.right.moment[0], 1e-3)
    with pytest.raises(InputError, match=r"pin_force: given .*; allowed are three numbers"):
        client.law(throw, pin_force=(0.0, 0.0, 1e4))
    with pytest.raises(InputError, match="gamma_deg: missing; the angle to the right neighbor"):
        client.law(throw, left_gamma_deg=240.0)
    webs = throw | {"left_web": {"thickness": 0.07}}
    assert client.law(webs, pin_force=force).remarks[1].startswith("No reactions: the law has")
    with pytest.raises(InputError, match="gamma_deg: given '120'; allowed is a number in deg"):
        client.law(throw, gamma_deg="120")
    with pytest.raises(InputError, match="gamma_deg: missing"):
        client.law(throw, pin_force=force, support="neighbors")


def test_outside_the_law_the_ratio_is_named(client, throw):
    with pytest.raises(InputError, match=r"crank_radius / main_journal_diameter: given 2\.27"):
        client.law(throw | {"crank_radius": 0.5})


def test_what_is_wrong_is_told_at_its_fields(service, throw):
    status, told = service.json(
        "/api/throws/validate", {"throw": throw | {"web_width": "5 kg", "pin_lenght": 1.0}}
    )
    assert status == 422
    assert [one["field"] for one in told["errors"]] == ["throw.web_width", "throw.pin_lenght"]
    with pytest.raises(InputError) as known:
        CrankThrow.from_text({"web_width": "5 kg"}, "throw")
    assert told["errors"][0]["message"] == known.value.sentences[0]
    status, told = service.json("/api/throws/outline", {"throw": throw, "view": "above"})
    assert status == 422
    assert told["errors"][0]["field"] == "view"
    assert "side" in told["detail"]


def test_the_client_raises_what_the_service_says(client, throw):
    with pytest.raises(InputError, match=r"web_width: given 9000 mm; .*allowed is"):
        client.validate(throw | {"web_width": 9.0})
    with pytest.raises(RefusedError, match="no job") as refused:
        client.job("0" * 16)
    assert refused.value.status == 404
    with pytest.raises(RefusedError, match="cannot be reached"):
        Client("http://127.0.0.1:9").models()


@pytest.mark.further
def test_an_analysis_gives_what_the_library_gives(client, throw):
    asked = {"accuracy": 0.05, "gamma_deg": 120.0, "pin_force": (0.0, -2e5, 0.0)}
    asked["left_gamma_deg"] = 180.0
    job = client.analyze_throw(throw, **asked, stress=True)
    steps = [one.step for one in client.follow(job)]
    assert "Meshing and solving" in steps
    found = client.result(job)["throw"]
    known = analyze_throw(CrankThrow(**throw), STEEL, 0.05)
    pinned = found["supports"]["pinned"]
    assert pinned["axial_compliance"] == close(known.axial_compliance(), 1e-9)
    reactions = known.reactions((0.0, -2e5, 0.0))
    assert pinned["reactions"]["left"]["force"] == close(list(reactions.left.force), 1e-6, 1e-3)
    unequal = found["supports"]["neighbors 180 and 120 deg"]["axial_compliance"]
    assert unequal == close(known.axial_compliance(Neighbors(180.0, 120.0)), 1e-9)
    assert pinned["errors"]["axial_compliance"] > 0.0
    job = client.job(job.id)
    assert {"result.json", "throw.step", "throw_view.json"} <= set(job.files)
    assert client.file(job, "throw.step").startswith(b"ISO-10303-21;")
    assert client.result(job)["fillets"]["loads"]


def test_models_are_listed_described_and_looked_up(client, throw):
    assert client.models() == ["six"]
    told = client.describe_model("six")
    assert told.ranges["web_thickness"] == (0.045, 0.09)
    one = client.lookup("six", throw=throw).responses["axial_compliance"]
    assert one.value == close(1.3e-9)
    assert one.lower < one.value < one.upper
    assert one.inside is True
    many = client.lookup(
        "six", {"web_thickness": [0.050, 0.068, 0.2]}, responses=["axial_compliance"]
    )
    assert many.rows == 3
    column = many.responses["axial_compliance"]
    assert column.inside == [True, True, False]
    assert column.lower[2] is None
    assert column.value[1] == close(1.3e-9)
    mixed = client.lookup(
        "six", {"web_thickness": ["50 mm", 0.068, 0.2]}, responses=["axial_compliance"]
    )
    assert mixed.responses["axial_compliance"].value == column.value


def test_lookups_that_cannot_be_are_refused_in_a_sentence(client):
    for wrong, said in (
        ({"web_thicknes": 0.07}, "unknown dimension"),
        ({" ": "60 mm"}, "' ': unknown dimension"),
        ({"web_thickness": [0.07] * 200_001}, "allowed is 200000 at most in one request"),
        ({"web_thickness": []}, "an empty list"),
        ({"web_thickness": [0.07, "thick"]}, "web_thickness"),
        ({"web_thickness": [[0.07]]}, "web_thickness"),
        ({"web_thickness": {"value": 1.0}}, "web_thickness"),
        ({"web_thickness": None}, "web_thickness"),
    ):
        with pytest.raises(InputError, match=said):
            client.lookup("six", wrong)
    with pytest.raises(RefusedError, match="no model"):
        client.lookup("seven")


def test_a_hundred_thousand_rows_are_looked_up(client):
    rows = [0.05 + 4e-7 * place for place in range(100_000)]
    start = time.perf_counter()
    found = client.lookup("six", {"web_thickness": rows}, responses=["axial_compliance"])
    assert (
        time.perf_counter() - start < 20.0
    )  # half a second on a quiet machine: benchmarks/load_service.py
    column = found.responses["axial_compliance"].value
    assert len(column) == 100_000
    alone = client.lookup("six", {"web_thickness": rows[777]}).responses["axial_compliance"].value
    assert column[777] == close(alone, 1e-12)
