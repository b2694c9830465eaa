"""What stands in the folder of a run, when one run follows another and when writing fails."""

import base64
import errno
import hashlib
import json
import shutil
from pathlib import Path

import pytest

from crankbase.errors import InputError, SolveError
from crankbase.outputs import LISTED, recording_run_files, replacing_files, write_text
from crankfem.jobs.run_computation import read_inputs
from crankfem.jobs.run_files import (
    MODEL,
    REPORT,
    RESULTS,
    STORE,
    check_folder,
    make_folder,
    replace_last_run,
    results_text,
    write_results,
)
from crankfem.report.writing import write_report_text

STORED = Path(__file__).with_name("report_results.json")
LEFT = {
    REPORT: "report",
    MODEL: "model",
    "throw.vtu": "mesh",
    "pictures/a.svg": "picture",
    "pictures/a.json": "plot",
}


@pytest.fixture
def finished(tmp_path):
    """The folder of a finished run, with a file of the user's among the pictures."""
    folder = make_folder(tmp_path / "run")
    (folder / STORE).write_text("old", encoding="utf-8")
    with recording_run_files():
        for name, kind in LEFT.items():
            write_text(folder / name, "old", kind)
    (folder / "pictures" / "mine.png").write_text("mine", encoding="utf-8")
    results = {"engine": "old", "pictures": {"a": "a.svg"}, "interactive": {"a": "a.json"}}
    write_results(folder, results)
    return folder


def files_of(folder):
    return sorted(path.name for path in folder.rglob("*") if path.is_file() and path.name != LISTED)


def fail(monkeypatch, owner, name, number=errno.ENOSPC):
    def refuse(*_, **__):
        raise OSError(number, "No space left on device")

    monkeypatch.setattr(owner, name, refuse)


def test_a_new_run_takes_the_place_of_the_last_one(finished):
    replace_last_run(finished, {"engine": "new"})
    assert files_of(finished) == ["mine.png", RESULTS, STORE]
    assert json.loads((finished / RESULTS).read_text(encoding="utf-8")) == {"engine": "new"}


@pytest.mark.parametrize("name", [REPORT, MODEL, "throw.vtu", "pictures/a.svg", "pictures/a.json"])
def test_what_the_user_has_changed_is_not_taken_away(finished, name):
    (finished / name).write_text("changed", encoding="utf-8")
    replace_last_run(finished, {"engine": "new"})
    assert files_of(finished) == sorted(["mine.png", RESULTS, STORE, Path(name).name])


@pytest.mark.parametrize("content", ["no JSON", "[]", '{"pictures": 3}', "\xff"])
def test_results_of_somebody_elses_stay(finished, content):
    (finished / RESULTS).write_text(content, encoding="latin-1")
    before = files_of(finished)
    with pytest.raises(InputError, match=r"results\.json: is not replaced, because it was changed"):
        replace_last_run(finished, {"engine": "new"})
    assert (finished / RESULTS).read_text(encoding="latin-1") == content
    assert files_of(finished) == before


def test_pictures_that_somebody_elses_results_name_stay(tmp_path):
    folder = make_folder(tmp_path / "run")
    (folder / "pictures" / "family.png").write_text("mine", encoding="utf-8")
    (folder / RESULTS).write_text('{"pictures": {"a": "family.png"}}', encoding="utf-8")
    with pytest.raises(InputError, match="crankfem"):
        check_folder(folder, study=False)
    with replacing_files():
        check_folder(folder, study=False)
        replace_last_run(folder, {})
    assert files_of(folder) == ["family.png", RESULTS]


@pytest.mark.parametrize("name", [RESULTS, REPORT, MODEL, "throw.vtu", "pictures/drawing.svg"])
@pytest.mark.parametrize("way", ["file", "link", "nowhere", "of a command"])
def test_a_file_in_the_way_is_refused_at_once(tmp_path, name, way):
    folder = make_folder(tmp_path / "run")
    other = tmp_path / "precious"
    other.write_text("precious", encoding="utf-8")
    kind = {".json": "results" if name == RESULTS else "model", ".html": "report", ".vtu": "mesh"}
    if way == "file":
        (folder / name).write_text("precious", encoding="utf-8")
    elif way == "of a command":
        write_text(folder / name, "precious", kind.get(Path(name).suffix, "picture"))
    else:
        (folder / name).symlink_to(other if way == "link" else tmp_path / "nowhere")
    with pytest.raises(InputError) as caught:
        check_folder(folder, study=True)
    assert str(folder / name) in str(caught.value)
    assert "--force" in str(caught.value)
    assert other.read_text(encoding="utf-8") == "precious"
    if name == MODEL:  # a run without a study writes none
        check_folder(folder, study=False)
        replace_last_run(folder, {})
        assert (folder / name).is_symlink() or (folder / name).is_file()


def test_a_folder_of_pictures_that_is_a_link_is_refused(tmp_path):
    (tmp_path / "run").mkdir()
    (tmp_path / "mine").mkdir()
    (tmp_path / "run" / "pictures").symlink_to(tmp_path / "mine")
    with pytest.raises(InputError, match="pictures: is a link"):
        check_folder(tmp_path / "run", study=False)


@pytest.mark.slow
def test_what_a_run_of_an_earlier_release_has_left_gives_way(
    coarsely, call, least_engine, model_file, tmp_path
):
    (tmp_path / "one.toml").write_text(least_engine, encoding="utf-8")
    assert call("run", "one.toml", "--output", "old").code == 0
    folder = tmp_path / "old"
    (folder / STORE).write_text("old", encoding="utf-8")
    model_file.rename(folder / MODEL)
    assert {REPORT, RESULTS, "throw.vtu", "drawing.svg"} <= set(files_of(folder))
    for place in (folder, folder / "pictures"):
        (place / LISTED).unlink()
    (folder / "pictures" / "mine.svg").write_text("mine", encoding="utf-8")
    # Named by the results or not: no run writes a picture of this name.
    results = json.loads((folder / RESULTS).read_text(encoding="utf-8"))
    results["pictures"]["mine"] = "mine.svg"
    (folder / RESULTS).write_text(json.dumps(results), encoding="utf-8")
    check_folder(folder, study=True)
    replace_last_run(folder, {})
    assert files_of(folder) == ["mine.svg", RESULTS, STORE]


def test_without_space_for_new_results_the_last_run_stays_whole(finished, monkeypatch):
    before = files_of(finished)
    with monkeypatch.context() as patch:
        fail(patch, Path, "write_text")
        with pytest.raises(OSError, match="No space left") as caught:
            replace_last_run(finished, {"engine": "new"})
    assert caught.value.errno == errno.ENOSPC
    assert caught.value.filename == str(finished / RESULTS)
    assert files_of(finished) == before
    assert json.loads((finished / RESULTS).read_text(encoding="utf-8"))["engine"] == "old"


def test_results_are_strict_json(tmp_path):
    with pytest.raises(SolveError, match="result a is nan"):
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


def put_results(folder, results):
    (folder / RESULTS).write_text(results_text(results), encoding="utf-8")


def test_report_says_what_it_leaves_out(reported, call):
    results = json.loads((reported / RESULTS).read_text(encoding="utf-8"))
    put_results(reported, results | {"pictures": {"drawing": "drawing.svg"}})
    answer = call("report", reported)
    assert answer.code == 0
    assert answer.err == "Note: Left out, because they cannot be read: drawing.svg.\n"
    assert answer.out.startswith("Report: ")
    assert call("report", reported, "--quiet").err == ""


def test_a_full_disk_is_not_blamed_on_the_results(reported, call, monkeypatch):
    write_report_text(reported / REPORT, "old")
    with monkeypatch.context() as patch:
        fail(patch, Path, "write_text")
        answer = call("report", reported)
    assert answer.code == 3
    assert answer.err == f"Error: {reported / REPORT}: No space left on device.\n"
    assert (reported / REPORT).read_text(encoding="utf-8") == "old"


def test_a_report_that_may_not_be_written_is_named(reported, call):
    (reported / REPORT).mkdir()
    answer = call("report", reported)
    assert answer.code == 2
    assert answer.err.startswith(f"Error: {reported / REPORT}: cannot be written, because it is a")


def test_a_report_that_no_run_has_written_stays(reported, call):
    (reported / REPORT).write_text("mine", encoding="utf-8")
    answer = call("report", reported)
    assert (answer.code, answer.out) == (2, "")
    assert answer.err.startswith(f"Error: {reported / REPORT}: is not replaced, because")
    assert (reported / REPORT).read_text(encoding="utf-8") == "mine"
    for options in (("--force",), (), ()):
        assert call("report", reported, *options).code == 0


@pytest.mark.parametrize("way", ["../out.svg", "{there}/out.svg", "link.svg", "..\\out.svg"])
def test_a_report_shows_nothing_from_outside_its_folder(reported, call, way):
    outside = reported.parent / "out.svg"
    outside.write_text("<svg>secret</svg>", encoding="utf-8")
    (reported / "pictures" / "link.svg").symlink_to(outside)
    named = way.format(there=reported.parent)
    results = json.loads((reported / RESULTS).read_text(encoding="utf-8"))
    put_results(reported, results | {"pictures": {"drawing": named}})
    answer = call("report", reported)
    assert answer.code == 0
    assert f"cannot be read: {named}." in answer.err
    secret = base64.b64encode(outside.read_bytes()).decode()
    assert secret not in (reported / REPORT).read_text(encoding="utf-8")


def test_a_folder_of_pictures_that_leads_elsewhere_is_not_read(reported, call):
    (reported / "pictures").rmdir()
    elsewhere = reported.parent / "elsewhere"
    elsewhere.mkdir()
    (elsewhere / "a.svg").write_text("<svg>secret</svg>", encoding="utf-8")
    (reported / "pictures").symlink_to(elsewhere)
    results = json.loads((reported / RESULTS).read_text(encoding="utf-8"))
    put_results(reported, results | {"pictures": {"drawing": "a.svg"}})
    assert "cannot be read: a.svg." in call("report", reported).err


def test_results_that_are_a_link_are_not_read(reported, call):
    (reported / RESULTS).rename(reported.parent / "moved.json")
    (reported / RESULTS).symlink_to(reported.parent / "moved.json")
    assert call("report", reported).code == 2


@pytest.mark.parametrize("content", ["[]", "{}", '{"about": 3}', "no JSON", "\xff", "NaN"])
def test_results_that_are_none_are_named(reported, call, content):
    (reported / RESULTS).write_text(content, encoding="latin-1")
    answer = call("report", reported)
    assert answer.code == 2
    assert f"{reported / RESULTS}: is not what crankfem run writes" in answer.err
