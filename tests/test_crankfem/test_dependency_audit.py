"""What `.ci/audit.py` makes of the reports of pip-audit: found, accepted, clean, not checked."""

import json
import stat
import sys
from pathlib import Path

import pytest

FOLDER = Path(__file__).resolve().parents[2] / ".ci"
pytestmark = pytest.mark.skipif(not FOLDER.exists(), reason="no checkout")
# Reports of pip-audit 2.10: one package with an advisory; one that the service did not know.
FOUND = {
    "name": "jinja2",
    "version": "2.4.1",
    "vulns": [{"id": "PYSEC-2021-66", "fix_versions": ["2.11.3"], "aliases": ["CVE-2020-28493"]}],
}
CLEAN = {"name": "numpy", "version": "2.4.6", "vulns": []}
SKIPPED = {"name": "numpy", "skip_reason": "Dependency not found on PyPI"}
LINE = "jinja2 2.4.1: PYSEC-2021-66 CVE-2020-28493, fixed in 2.11.3"


@pytest.fixture
def audit(monkeypatch):
    monkeypatch.syspath_prepend(str(FOLDER))
    import audit

    yield audit
    del sys.modules["audit"]


@pytest.mark.parametrize(
    ("packages", "lines", "code"),
    [
        ([FOUND, CLEAN, SKIPPED], [LINE], 1),
        ([CLEAN, CLEAN, SKIPPED], ["Known vulnerabilities: none in 2 packages."], 0),
        (
            [SKIPPED],
            ["Known vulnerabilities: not checked, for no advisory service could be reached."],
            0,
        ),
    ],
    ids=["found", "clean", "not checked"],
)
def test_reports(audit, tmp_path, capsys, packages, lines, code):
    program = tmp_path / "pip-audit"
    report = json.dumps({"dependencies": packages, "fixes": []})
    program.write_text(f"#!/bin/sh\ncat <<'END'\n{report}\nEND\nexit 1\n")
    program.chmod(program.stat().st_mode | stat.S_IXUSR)
    assert audit.main(str(program), "unused") == code
    assert capsys.readouterr().out.splitlines() == lines


def test_without_the_program_nothing_is_checked(audit, tmp_path, capsys):
    assert audit.main(str(tmp_path / "none"), "unused") == 0
    assert "not checked" in capsys.readouterr().out


def test_an_advisory_is_accepted_by_any_of_its_names(audit):
    lines, good = audit.judge([FOUND], {"CVE-2020-28493": "no page is made from foreign text"})
    assert good
    assert lines == [f"{LINE}; accepted: no page is made from foreign text"]
