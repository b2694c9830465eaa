"""The routes: what they answer, their description, and files that fields name."""

import asyncio
import json
import re
import shutil
import subprocess
import sys
import time
from contextlib import suppress

import pytest
from fastapi import APIRouter
from hypothesis import HealthCheck, given, settings
from starlette.responses import PlainTextResponse

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
from crankfem.satellites.service.asking import ProblemError
from crankfem.satellites.service.model_routes import QuickRoutes
from crankfem.satellites.service.tasks import check_upload
from file_fields import SECRET, fields, plant, tells, text_with, upwards
from regression.law.throw_law import axial_law_slopes
from satellites.service.serving import ROOT, STUDY


@pytest.fixture
def client(service):
    return Client(service.address)


def test_a_throw_in_numbers_and_in_texts_is_the_same(client, throw):
    texts = {name: f"{1000.0 * value:g} mm" for name, value in throw.items()}
    found, same = client.validate(throw), client.validate(texts)
    assert found.dimensions == same.dimensions == throw
    assert found.shape.length == close(CrankThrow(**throw).length)
    assert client.outline(throw) == client.outline(texts)


def test_dimensions_on_the_outline_have_the_letters_of_their_fields(service, throw):
    lettered = ""
    for view in ("side", "front"):
        asked = {"throw": throw, "view": view, "letters": True}
        lettered += service.ask("/api/throws/outline", asked)[2].decode()
    assert set(re.findall(r'data-field="(\w+)"', lettered)) == set(throw)


def test_the_file_of_a_throw_says_the_same(client, throw, tmp_path):
    given = throw | {
        "web_outline": "rectangle",
        "left_web": {"thickness": 0.07},
        "counterweight": {"outer_radius": 0.3, "angle": 1.5},
    }
    file = tmp_path / "mine.toml"
    file.write_text(client.validate(given).toml)
    assert client.check_file(file).kind == "throw"
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


@pytest.mark.slow
def test_the_law_answers_with_bands_and_reactions(client, throw):
    force = (2e4, -2e5, 0.0)
    asked = {"gamma_deg": 120.0, "pin_force": force, "support": "neighbors"}
    found = client.law(throw, **asked)
    axial, torsional = axial_law(CrankThrow(**throw)), torsional_law(CrankThrow(**throw))
    assert found.values["axial_compliance_pinned"].value == close(axial.pinned)
    assert found.values["axial_compliance_pinned"].lower == close(axial.band[0])
    assert found.values["axial_compliance_neighbors"].value == close(float(axial.axial(120.0)))
    between = law_answers(CrankThrow(**throw), STEEL, 120.0)["axial_compliance"]
    assert found.values["axial_compliance_neighbors"].upper == close(between.upper)
    assert found.values["torsional_compliance_guided"].value == close(torsional.guided)
    known = law_reactions(CrankThrow(**throw), force, Neighbors(120.0, 120.0))
    assert found.reactions.left.force == close(known.left.force.tolist())
    assert found.reactions.right.moment == close(known.right.moment.tolist())
    assert found.reactions.left.force_band[2] == close(known.band.left.force[2])
    assert client.law(throw).reactions is None
    assert client.law(throw, ranges=True).ranges["pin_diameter"].high == close(0.22)
    assert client.law(throw).slopes is None
    assert client.law(throw, slopes=True).slopes == close(axial_law_slopes(CrankThrow(**throw)))
    unequal = client.law(throw, **asked, left_gamma_deg=240.0).reactions
    known = law_reactions(CrankThrow(**throw), force, Neighbors(240.0, 120.0))
    assert unequal.right.moment == close(known.right.moment.tolist())
    assert unequal.right.moment[0] != close(found.reactions.right.moment[0], 1e-3)
    with pytest.raises(InputError, match=r"pin_force: given .*; allowed are three numbers"):
        client.law(throw, pin_force=(0.0, 0.0, 1e4))
    written = client.law(throw, **asked | {"pin_force": ("20 kN", "-200 kN", 0.0)})
    assert written.reactions == found.reactions
    with pytest.raises(InputError, match=r"pin_force\[1]: given '-9 kN m', which is no force"):
        client.law(throw, pin_force=(0.0, "-9 kN m", 0.0))
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


@pytest.mark.slow
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
    assert "Meshing and solving" in [one.step for one in client.follow(job)]
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


def test_models_are_listed_described_and_looked_up(serve, models, tmp_path, throw):
    # A service of its own: models of studies that others have it make are listed, too.
    client = Client(serve(tmp_path, "--models", str(models)).address)
    assert client.models() == ["six"]
    assert client.describe_model("six").ranges["web_thickness"] == (0.045, 0.09)
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


@pytest.mark.slow
def test_no_dimension_and_no_constant_is_dropped_unsaid(client, throw):
    """Each changed by 3 %: the answer changes, is refused, or names what it does not use."""
    steel = STEEL.model_dump()

    def looked_up(throw, material):
        try:
            return client.lookup("six", throw=throw, material=material)
        except InputError as error:
            return str(error)

    doors = [
        looked_up,
        client.validate,
        lambda *asked: client.formulas(asked[0], material=asked[1]),
    ]
    doors.append(lambda *asked: client.law(asked[0], material=asked[1]))
    for ask in doors:
        before = ask(throw, steel)
        named = getattr(before, "not_used", [])
        assert named == (["material.density"] if hasattr(before, "not_used") else [])
        unchanged = [
            f"{section}.{name}"
            for section, values in (("throw", throw), ("material", steel))
            for name, value in values.items()
            if ask(
                *(
                    given | ({name: 1.03 * value} if given is values else {})
                    for given in (throw, steel)
                )
            )
            == before
        ]
        # The model of compliances holds no mass.
        assert unchanged == (named or (["material.density"] if ask is looked_up else []))


@pytest.mark.slow
def test_lookups_that_cannot_be_are_refused_in_a_sentence(client):
    for wrong, said in (
        ({"web_thicknes": 0.07}, "unknown dimension"),
        ({" ": "60 mm"}, "' ': unknown dimension"),
        ({"web_thickness": [0.07] * 200_001}, "allowed are 100000 throws at most"),
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


@pytest.mark.slow
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


routes = APIRouter()


@routes.post("/say/{word}")
async def say(request, word):
    if word == "nothing":
        raise ProblemError(404, "There is nothing.")
    if word == "wrong":
        raise InputError("word: given wrong; allowed is another.")
    if word == "broken":
        raise ValueError(word)
    return PlainTextResponse(f"{word} {len(await request.body())}")


async def framework(scope, receive, send):
    await PlainTextResponse("framework")(scope, receive, send)


def post(path, method="POST"):
    """Return status and body of a request that is answered, and the error that it raises."""
    sent = []

    async def receive():
        return {"type": "http.request", "body": b"four"}

    async def send(message):
        sent.append(message)

    scope = {"type": "http", "method": method, "path": path, "headers": []}
    error = None
    try:
        asyncio.run(QuickRoutes(framework, routes.routes)(scope, receive, send))
    except ValueError as raised:
        error = raised
    return sent[0]["status"], sent[1]["body"].decode(), error


def test_its_routes_are_answered_and_others_left():
    assert post("/say/word") == (200, "word 4", None)
    assert post("/say/word", "GET") == (200, "framework", None)
    assert post("/say/two/words") == (200, "framework", None)


@pytest.mark.parametrize(
    ("word", "status", "told"),
    [
        ("nothing", 404, "There is nothing."),
        ("wrong", 422, "word: given wrong; allowed is another."),
    ],
)
def test_refusals_are_problems(word, status, told):
    found, body, _ = post(f"/say/{word}")
    assert found == status
    assert json.loads(body)["detail"] == told


def test_a_fault_is_answered_and_raised_for_the_log():
    status, body, error = post("/say/broken")
    assert status == json.loads(body)["status"] == 500
    assert str(error) == "broken"


TEXTS = [(kind, path, file) for kind, path, takes, file in fields() if takes]
EVENTS = ("open", "os.listdir", "os.scandir")
FILES = [(kind, path) for kind, path, file in TEXTS if file]


@pytest.fixture(scope="module")
def planted(tmp_path_factory):
    return plant(tmp_path_factory.mktemp("planted"))


def asked(service, route, kind, path, value):
    """Send a file with a value in one field; return status and answer, which tells nothing of the server."""
    question = {"text": text_with(kind, path, value), "name": "mine.toml"}
    status, _, body = service.ask(route, question)
    answer = body.decode()
    assert not tells(answer, service.folder, ROOT, "/crankfem-"), (path, value)
    return status, answer


@pytest.mark.slow
@pytest.mark.parametrize(("kind", "path", "file"), TEXTS)
def test_no_field_opens_a_file_that_was_not_sent(service, planted, kind, path, file):
    for value in (str(planted[0]), upwards(planted[-1])):
        status, answer = asked(service, "/api/files/check", kind, path, value)
        assert status in (200, 422)
        assert not file or "among the files sent with mine.toml" in answer


@pytest.fixture(scope="module")
def opened():
    """All that this process opens or lists."""
    found = []
    sys.addaudithook(lambda event, given: found.append(str(given[0])) if event in EVENTS else None)
    return found


@pytest.mark.slow
def test_reading_what_was_sent_opens_nothing_else(planted, opened):
    open(planted[0]).close()
    assert str(planted[0]) in opened
    opened.clear()
    for kind, path, _ in TEXTS:
        for value in (str(planted[0]), upwards(planted[1])):
            with suppress(InputError):
                check_upload({"text": text_with(kind, path, value), "name": "mine.toml"})
    assert not [place for place in opened if planted[0].parent.name in place]


@pytest.mark.slow
@pytest.mark.parametrize(("kind", "path"), FILES)
def test_no_job_begins_with_a_file_that_was_not_sent(service, planted, kind, path):
    for value in (str(planted[0]), "/proc/self/environ", "/dev/zero", "../jobs.sqlite"):
        for route in ("/api/engines", "/api/studies"):
            status, answer = asked(service, route, kind, path, value)
            assert status == 422
            assert "files sent with mine.toml" in answer


@pytest.mark.slow
def test_what_was_sent_is_read_and_named_as_sent(service):
    for kind, path in FILES:
        name = "mine.json" if path == ("vibration", "model") else "mine.csv"
        question = {"text": text_with(kind, path, name), "tables": {name: f"{SECRET},1\n2,3\n"}}
        status, told = service.json("/api/files/check", question)
        assert status == 422
        assert SECRET in told["detail"] or name in told["detail"], path
        assert "files sent" not in told["detail"]


@pytest.mark.slow
def test_uploads_have_a_folder_of_their_own(service):
    tables = {"result.json": "{}", "model.json": "{}", "throw.toml": ""}
    question = {"text": STUDY, "name": "study.toml", "tables": tables}
    _, told = service.json("/api/studies", question)
    job = f"/api/jobs/{told['id']}"
    sent = {f"sent/{name}" for name in ("study.toml", *tables)}
    deadline = time.monotonic() + 60.0
    while not sent <= set(service.json(job)[1]["files"]):  # they are written one after the other
        assert time.monotonic() < deadline
    assert f"job-{told['id']}" not in service.json("/api/models")[1]["models"]
    assert service.ask(f"{job}/result")[0] == 404
    assert service.ask(f"{job}/files/sent/result.json")[2] == b"{}"
    service.ask(f"{job}/cancel", method="POST")
    service.wait(told["id"], "canceled")


@pytest.mark.further
def test_a_job_whose_tables_are_named_like_its_results_ends_well(service):
    tables = {"result.json": "{}", "model.json": "{}"}
    question = {"text": STUDY, "name": "study.toml", "tables": tables}
    _, told = service.json("/api/studies", question)
    ended = service.wait(told["id"], "done", "failed")
    assert ended["state"] == "done", ended
    job = f"/api/jobs/{told['id']}"
    assert service.json(f"{job}/result")[1]["runs"] > 0
    assert service.json(f"{job}/files/model.json")[1]["format"] == "crankfem compliance model"
    for name in ended["files"]:
        text = service.ask(f"{job}/files/{name}")[2].decode()
        assert not tells(text, service.folder, ROOT), name
    assert not tells(json.dumps(ended), service.folder, ROOT)


schemathesis = pytest.importorskip("schemathesis", reason="needs crankfem[test]")

# Requests for each path and method. One that fits the description may still be refused: dimensions must fit
# each other, and names must be there.
EXAMPLES = 30
CHECKS = (
    "not_a_server_error",
    "status_code_conformance",
    "content_type_conformance",
    "response_headers_conformance",
    "response_schema_conformance",
    "negative_data_rejection",
)
# These begin jobs: they are asked less often.
JOBS = ("/api/throws/analysis", "/api/throws/stress", "/api/studies", "/api/engines")


@pytest.fixture(scope="module")
def operations(service):
    schema = schemathesis.openapi.from_url(f"{service.address}/api/openapi.json")
    return [found.ok() for found in schema.get_all_operations()]


@pytest.mark.further
@pytest.mark.parametrize("mode", ["POSITIVE", "NEGATIVE"])
def test_every_answer_is_as_described(service, operations, mode):
    checks = [schemathesis.checks.CHECKS.get_one(name) for name in CHECKS]
    kind = getattr(schemathesis.GenerationMode, mode)
    assert len(operations) >= 18
    answered = 0
    for operation in operations:
        if mode == "NEGATIVE" and not list(operation.body):
            continue

        @given(case=operation.as_strategy(generation_mode=kind))
        @settings(
            max_examples=6 if operation.path in JOBS else EXAMPLES,
            deadline=None,
            suppress_health_check=list(HealthCheck),
        )
        def ask(case):
            nonlocal answered
            case.call_and_validate(checks=checks, timeout=120)
            answered += 1

        ask()
    assert answered > 100
    assert "Traceback" not in service.log.read_text()


def test_the_description_names_every_field_with_its_unit(service):
    _, _, text = service.ask("/api/openapi.json")
    fields = json.loads(text)["components"]["schemas"]["CrankThrow"]["properties"]
    assert fields["crank_radius"]["description"] == "crank radius, half the stroke [m]"
    assert fields["left_web"]["anyOf"][0]["properties"]["thickness"]["anyOf"]


ADDRESS = "http://127.0.0.1:8765"
PAGE = (ROOT / "docs" / "service.md").read_text(encoding="utf-8")


def block(language):
    return re.search(rf"```{language}\n(.*?)```", PAGE, re.DOTALL)[1]


@pytest.mark.skipif(shutil.which("curl") is None, reason="there is no curl")
def test_the_curl_examples_are_answered(service):
    text = block("sh").replace(ADDRESS, service.address)
    done = subprocess.run(["bash", "-ec", text], capture_output=True, text=True, check=True)
    decoder, place, answers = json.JSONDecoder(), 0, []
    while place < len(done.stdout):
        answer, place = decoder.raw_decode(done.stdout, place)
        answers.append(answer)
    law, job, jobs = answers
    assert 1.2e-9 < law["values"]["axial_compliance_pinned"]["value"] < 1.4e-9
    assert job["id"] in [one["id"] for one in jobs["jobs"]]


@pytest.mark.further
def test_the_client_example_runs(service, capsys):
    exec(block("python").replace(ADDRESS, service.address), {})
    law, *states, found = capsys.readouterr().out.splitlines()
    assert re.fullmatch(r"1\.2\de-09 m/N, 1\.2\de-09 to 1\.\d\de-09", law)
    assert states[-1].split() == ["done"]
    assert float(found.removesuffix(" m/N")) == close(1.281e-9, rel=0.01)  # docs/accuracy.md


def test_every_path_of_the_page_is_in_the_description(service):
    _, _, text = service.ask("/api/openapi.json")
    known = set(json.loads(text)["paths"])
    named = set(re.findall(r"/api/(?:throws|files|jobs|models|studies|engines)[\w/]*", PAGE))
    assert {path.replace("/ID", "/{name}").replace("/NAME", "/{name}") for path in named} <= known
