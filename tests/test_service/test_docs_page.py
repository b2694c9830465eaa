"""The examples of docs/service.md, word for word, at a service that runs."""

import json
import re
import shutil
import subprocess

import pytest

from serving import ROOT

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


@pytest.mark.slow
def test_the_client_example_runs(service, capsys):
    exec(block("python").replace(ADDRESS, service.address), {})
    law, *states, found = capsys.readouterr().out.splitlines()
    assert re.fullmatch(r"1\.2\de-09 m/N, 1\.2\de-09 to 1\.\d\de-09", law)
    assert states[-1].split() == ["done"]
    assert re.fullmatch(r"1\.(29|30)e-09 m/N", found)


def test_every_path_of_the_page_is_in_the_description(service):
    _, _, text = service.ask("/api/openapi.json")
    known = set(json.loads(text)["paths"])
    named = set(re.findall(r"/api/(?:throws|files|jobs|models|studies|engines)[\w/]*", PAGE))
    assert {path.replace("/ID", "/{name}").replace("/NAME", "/{name}") for path in named} <= known
