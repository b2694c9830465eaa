"""Files that fields name: those sent are read, no other is, and what a job writes is its own."""

import json
import sys
from contextlib import suppress

import pytest

from crankbase.errors import InputError
from crankfem.service.tasks import check_upload
from file_fields import SECRET, fields, plant, tells, text_with, upwards
from serving import ROOT, STUDY

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


def test_reading_what_was_sent_opens_nothing_else(planted, opened):
    open(planted[0]).close()
    assert str(planted[0]) in opened
    opened.clear()
    for kind, path, _ in TEXTS:
        for value in (str(planted[0]), upwards(planted[1])):
            with suppress(InputError):
                check_upload({"text": text_with(kind, path, value), "name": "mine.toml"})
    assert not [place for place in opened if planted[0].parent.name in place]


@pytest.mark.parametrize(("kind", "path"), FILES)
def test_no_job_begins_with_a_file_that_was_not_sent(service, planted, kind, path):
    for value in (str(planted[0]), "/proc/self/environ", "/dev/zero", "../jobs.sqlite"):
        for route in ("/api/engines", "/api/studies"):
            status, answer = asked(service, route, kind, path, value)
            assert status == 422
            assert "files sent with mine.toml" in answer


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
    while not (files := service.json(job)[1]["files"]):
        pass
    assert set(files) >= {f"sent/{name}" for name in ("study.toml", *tables)}
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
