"""What stands in the folder of a run, when one run follows another and when writing fails."""

import errno
import hashlib
import json
import shutil
from pathlib import Path

import pytest

from crankbase.errors import InputError
from crankfem.jobs.run_files import (
    MODEL,
    REPORT,
    RESULTS,
    STORE,
    make_folder,
    replace_last_run,
    write_results,
    write_whole,
)
from crankfem.jobs.run_inputs import read_inputs

STORED = Path(__file__).with_name("report_results.json")


@pytest.fixture
def finished(tmp_path):
    """The folder of a finished run, with a file of the user's among the pictures."""
    folder = make_folder(tmp_path / "run")
    for name in (REPORT, MODEL, STORE, "throw.vtu", "pictures/a.svg", "pictures/a.json"):
        (folder / name).write_text("old", encoding="utf-8")
    (folder / "pictures" / "mine.png").write_text("mine", encoding="utf-8")
    results = {"engine": "old", "pictures": {"a": "a.svg"}, "interactive": {"a": "a.json"}}
    write_results(folder, results)
    return folder


def files_of(folder):
    return sorted(path.name for path in folder.rglob("*") if path.is_file())


def fail(monkeypatch, name, number=errno.ENOSPC):
    def refuse(*_, **__):
        raise OSError(number, "No space left on device")

    monkeypatch.setattr(Path, name, refuse)


def test_a_new_run_takes_the_place_of_the_last_one(finished):
    replace_last_run(finished, {"engine": "new"})
    assert files_of(finished) == ["mine.png", RESULTS, STORE]
    assert json.loads((finished / RESULTS).read_text(encoding="utf-8")) == {"engine": "new"}


@pytest.mark.parametrize("content", ["no JSON", "[]", '{"pictures": 3}', "\xff"])
def test_results_that_are_none_are_replaced_all_the_same(finished, content):
    (finished / RESULTS).write_text(content, encoding="latin-1")
    replace_last_run(finished, {"engine": "new"})
    assert files_of(finished) == ["a.json", "a.svg", "mine.png", RESULTS, STORE]


def test_nothing_outside_the_folder_of_pictures_is_taken_away(finished):
    (finished.parent / "other.svg").write_text("other", encoding="utf-8")
    results = {"pictures": {"a": "../../other.svg", "b": "../study.sqlite"}, "interactive": {}}
    write_results(finished, results)
    replace_last_run(finished, {})
    assert (finished.parent / "other.svg").is_file()
    assert (finished / STORE).is_file()


def test_without_space_for_new_results_the_last_run_stays_whole(finished, monkeypatch):
    before = files_of(finished)
    with monkeypatch.context() as patch:
        fail(patch, "write_text")
        with pytest.raises(OSError, match="No space left") as caught:
            replace_last_run(finished, {"engine": "new"})
    assert caught.value.errno == errno.ENOSPC
    assert caught.value.filename == str(finished / RESULTS)
    assert files_of(finished) == before
    assert json.loads((finished / RESULTS).read_text(encoding="utf-8"))["engine"] == "old"


@pytest.mark.parametrize("step", ["write_text", "replace"])
def test_a_file_that_cannot_be_written_stays_what_it_was(tmp_path, monkeypatch, step):
    path = write_whole(tmp_path / "a.html", "old")
    with monkeypatch.context() as patch:
        fail(patch, step, errno.EACCES)
        with pytest.raises(PermissionError) as caught:
            write_whole(path, "new")
    assert caught.value.filename == str(path)
    assert path.read_text(encoding="utf-8") == "old"
    assert files_of(tmp_path) == ["a.html"]


def test_results_are_strict_json(tmp_path):
    with pytest.raises(ValueError, match="JSON"):
        write_results(tmp_path, {"a": float("nan")})


def test_a_file_in_the_way_of_the_folder(tmp_path):
    (tmp_path / "a").write_text("", encoding="utf-8")
    with pytest.raises(InputError, match=r"^output: given '.*a', which cannot be made or written"):
        make_folder(tmp_path / "a")


def test_texts_of_inputs_are_those_that_were_read(tmp_path, quick_four):
    (tmp_path / "four.toml").write_text(quick_four, encoding="utf-8")
    inputs = read_inputs(tmp_path / "four.toml")
    (tmp_path / "four.toml").unlink()
    engine, table = inputs.files
    assert (engine["name"], engine["text"]) == ("four.toml", quick_four)
    assert engine["sha256"] == hashlib.sha256(quick_four.encode()).hexdigest()
    assert table["name"] == "yamz5340_torque_one_throw.csv"


@pytest.fixture
def reported(tmp_path):
    """The folder of a run whose report can be written."""
    shutil.copyfile(STORED, tmp_path / RESULTS)
    (tmp_path / "pictures").mkdir()
    return tmp_path


def test_report_says_what_it_leaves_out(reported, call):
    results = json.loads((reported / RESULTS).read_text(encoding="utf-8"))
    write_results(reported, results | {"pictures": {"drawing": "drawing.svg"}})
    answer = call("report", reported)
    assert answer.code == 0
    assert answer.err == "Note: Left out, because they cannot be read: drawing.svg.\n"
    assert answer.out.startswith("Report: ")
    assert call("report", reported, "--quiet").err == ""


def test_a_full_disk_is_not_blamed_on_the_results(reported, call, monkeypatch):
    write_whole(reported / REPORT, "old")
    with monkeypatch.context() as patch:
        fail(patch, "write_text")
        answer = call("report", reported)
    assert answer.code == 3
    assert answer.err == f"Error: {reported / REPORT}: No space left on device.\n"
    assert (reported / REPORT).read_text(encoding="utf-8") == "old"


def test_a_report_that_may_not_be_written_is_named(reported, call):
    (reported / REPORT).mkdir()
    answer = call("report", reported)
    assert answer.code == 2
    assert answer.err == f"Error: {reported / REPORT}: Is a directory.\n"


@pytest.mark.parametrize("content", ["[]", "{}", '{"about": 3}', "no JSON", "\xff", "NaN"])
def test_results_that_are_none_are_named(reported, call, content):
    (reported / RESULTS).write_text(content, encoding="latin-1")
    answer = call("report", reported)
    assert answer.code == 2
    assert f"{reported / RESULTS}: is not what crankfem run writes" in answer.err
