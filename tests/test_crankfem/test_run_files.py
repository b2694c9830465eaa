"""The folder of a run, its pictures, and what each command that writes does to files that are there."""

import base64
import errno
import hashlib
import json
import os
import shutil
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import pytest

import crankfem as cf
from crankbase.diagrams import figure
from crankbase.errors import InputError, MissingLibraryError, RenderError, SolveError
from crankbase.outputs import LISTED, atomic_file, recording_run_files, replacing_files, write_text
from crankfem.analyses.throw.pictures import offscreen, stress_picture
from crankfem.analyses.throw.pictures.offscreen import ADVICE, OffscreenProcess, render_failure
from crankfem.analyses.vibration.run import engine_vibration
from crankfem.files.reading.data_files import data_folder, input_path
from crankfem.jobs.run_computation import read_inputs
from crankfem.jobs.run_drawing import Pictures, Renderings
from crankfem.jobs.run_files import (
    MODEL,
    PICTURES,
    REPORT,
    RESULTS,
    STORE,
    check_folder,
    make_folders,
    replace_last_run,
    results_text,
    write_results,
)
from crankfem.report.interactive.plot import Plot, Plots
from crankfem.report.writing import write_report_text
from regression.models.compliance_model import ComplianceModel
from satellite_cases import of_satellites
from stand_ins import calculate_satellites_once, put_everywhere, stored_results

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
    folder = make_folders(tmp_path / "run", PICTURES)
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


def test_pictures_that_somebody_elses_results_name_stay(tmp_path):
    folder = make_folders(tmp_path / "run", PICTURES)
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
    folder = make_folders(tmp_path / "run", PICTURES)
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
    with pytest.raises(InputError, match=r"^output: "):
        make_folders(tmp_path / "a", PICTURES)


@pytest.mark.slow
def test_texts_of_inputs_are_those_that_were_read(tmp_path, quick_four):
    (tmp_path / "four.toml").write_text(quick_four, encoding="utf-8")
    inputs = read_inputs(tmp_path / "four.toml")
    (tmp_path / "four.toml").unlink()
    engine, table = inputs.files
    assert (engine.name, engine.text) == ("four.toml", quick_four)
    assert engine.sha256 == hashlib.sha256(quick_four.encode()).hexdigest()
    assert table.name == "yamz5340_torque_one_throw.csv"


@pytest.fixture
def reported(tmp_path):
    """The folder of a run whose report can be written."""
    put_results(tmp_path, stored_results())
    (tmp_path / "pictures").mkdir()
    return tmp_path


def put_results(folder, results):
    (folder / RESULTS).write_text(results_text(results), encoding="utf-8")


@pytest.mark.slow
def test_report_says_what_it_leaves_out(reported, call):
    results = json.loads((reported / RESULTS).read_text(encoding="utf-8"))
    put_results(reported, results | {"pictures": {"drawing": "drawing.svg"}})
    answer = call("report", reported)
    assert answer.code == 0
    assert answer.err.endswith(": drawing.svg.\n")
    assert answer.out.startswith("Report: ")
    assert call("report", reported, "--quiet").err == ""


def test_a_full_disk_is_not_blamed_on_the_results(reported, call, monkeypatch):
    write_report_text(reported / REPORT, "old")
    with monkeypatch.context() as patch:
        fail(patch, Path, "write_text")
        answer = call("report", reported)
    assert answer.code == 3
    assert answer.err.startswith(f"Error: {reported / REPORT}: ")
    assert (reported / REPORT).read_text(encoding="utf-8") == "old"


def test_a_report_that_may_not_be_written_is_named(reported, call):
    (reported / REPORT).mkdir()
    answer = call("report", reported)
    assert answer.code == 2
    assert answer.err.startswith(f"Error: {reported / REPORT}: ")


@pytest.mark.slow
def test_a_report_that_no_run_has_written_stays(reported, call):
    (reported / REPORT).write_text("mine", encoding="utf-8")
    answer = call("report", reported)
    assert (answer.code, answer.out) == (2, "")
    assert answer.err.startswith(f"Error: {reported / REPORT}: ")
    assert (reported / REPORT).read_text(encoding="utf-8") == "mine"
    for options in (("--force",), (), ()):
        assert call("report", reported, *options).code == 0


@pytest.mark.slow
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
    assert answer.err.endswith(f": {named}.\n")
    secret = base64.b64encode(outside.read_bytes()).decode()
    assert secret not in (reported / REPORT).read_text(encoding="utf-8")


@pytest.mark.slow
def test_a_folder_of_pictures_that_leads_elsewhere_is_not_read(reported, call):
    (reported / "pictures").rmdir()
    elsewhere = reported.parent / "elsewhere"
    elsewhere.mkdir()
    (elsewhere / "a.svg").write_text("<svg>secret</svg>", encoding="utf-8")
    (reported / "pictures").symlink_to(elsewhere)
    results = json.loads((reported / RESULTS).read_text(encoding="utf-8"))
    put_results(reported, results | {"pictures": {"drawing": "a.svg"}})
    assert ": a.svg." in call("report", reported).err


def test_results_that_are_a_link_are_not_read(reported, call):
    (reported / RESULTS).rename(reported.parent / "moved.json")
    (reported / RESULTS).symlink_to(reported.parent / "moved.json")
    assert call("report", reported).code == 2


@pytest.mark.parametrize("content", ["[]", "{}", '{"about": 3}', "no JSON", "\xff", "NaN"])
def test_results_that_are_none_are_named(reported, call, content):
    (reported / RESULTS).write_text(content, encoding="latin-1")
    answer = call("report", reported)
    assert answer.code == 2
    assert f"{reported / RESULTS}: " in answer.err


@pytest.fixture
def told():
    return []


@pytest.fixture
def pictures(tmp_path, told):
    return Pictures(tmp_path, told.append)


def write(path):
    path.write_text("picture", encoding="utf-8")


def write_half_and_fail(path):
    with atomic_file(path, "picture") as part:
        write(part)
        raise ValueError("no such thing")


def picture_fail(*_):
    raise OSError(28, "No space left on device", "b.json")


class Made:
    """A renderer that makes its file, or fails."""

    def __init__(self, folder, error=None):
        self.error, self.stopped = error, False
        write(folder / "mesh.png")

    def wait(self):
        if self.error is not None:
            raise self.error

    def stop(self):
        self.stopped = True


def test_one_plot_that_fails_leaves_the_others(pictures, told, tmp_path):
    figure = ([], {})
    pictures.draw(
        Plots(
            (
                Plot("a", "", "", lambda path, _: write(path), lambda _: figure),
                Plot("b", "", "", lambda path, _: write_half_and_fail(path)),
                Plot("c", "", "", lambda path, _: write(path), picture_fail),
                Plot("d", "", "", lambda path, _: write(path), needs="gas"),
            )
        ),
        None,
    )
    # One that cannot be made for a screen is drawn on paper.
    assert pictures.static == {"c": "c.svg"}
    assert pictures.interactive == {"a": "a.json"}
    assert {path.name for path in tmp_path.glob("[!.]*")} == {"c.svg", "a.json"}
    assert told == pictures.notes
    first, second = told
    assert "picture b: ValueError: " in first
    assert "plot c: b.json: " in second


def test_nothing_is_drawn_over_what_is_somebody_elses(tmp_path):
    (tmp_path / "b.svg").write_text("precious", encoding="utf-8")
    plots = Plots(tuple(Plot(name, "", "", lambda path, _: write(path)) for name in "ab"))
    with pytest.raises(InputError, match=r"b\.svg: "):
        plots.draw(tmp_path, None)
    assert not (tmp_path / "a.svg").exists()


def test_an_interrupt_is_no_picture_that_fails(pictures):
    def interrupt():
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        pictures.attempt("picture", interrupt)


def test_rendered_pictures_come_into_the_folder_at_the_end_only(pictures, told, tmp_path):
    made = []
    with Renderings() as renderings:
        renderings.start(
            "mesh", {"mesh": "mesh.png"}, lambda folder: made.append(folder) or Made(folder)
        )
        assert not (tmp_path / "mesh.png").exists()
        renderings.collect(pictures)
        assert (tmp_path / "mesh.png").read_text(encoding="utf-8") == "picture"
    assert pictures.static == {"mesh": "mesh.png"}
    assert not made[0].exists()


@pytest.mark.slow
def test_one_rendering_that_fails_leaves_the_others(pictures, told):
    missing = MissingLibraryError("install it")
    with Renderings() as renderings:
        renderings.start("picture of stresses", {"stress": "x.png"}, picture_fail)
        renderings.start("solid", {"solid": "x.png"}, lambda folder: Made(folder, missing))
        renderings.start("deck", {"deck": "x.png"}, lambda folder: Made(folder, missing))
        renderings.start("mesh", {"mesh": "mesh.png"}, Made)
        renderings.collect(pictures)
    assert pictures.static == {"mesh": "mesh.png"}
    assert told == [
        "There is no picture of stresses: b.json: No space left on device.",
        "install it",
    ]


def test_renderings_are_stopped_when_a_run_fails():
    made = []

    def run():
        with Renderings() as renderings:
            renderings.start("mesh", {}, lambda folder: made.append(Made(folder)) or made[0])
            raise ZeroDivisionError

    with pytest.raises(ZeroDivisionError):
        run()
    assert made[0].stopped


# What VTK and Python wrote where nothing could be rendered.
NO_EGL = "vtkOpenGLRenderWindow.c:669 WARN| Failed to load EGL! Please install the EGL library\n"


@pytest.mark.parametrize(
    ("reason", "said", "kind", "sentence"),
    [
        ("the process for it was ended by SIGSEGV", NO_EGL, MissingLibraryError, ADVICE),
        (
            "ModuleNotFoundError: No module named 'pyvista'",
            "",
            MissingLibraryError,
            "could not be rendered: No module named 'pyvista'",
        ),
        (
            "the process for it died (exit code 1)",
            "Traceback\nOSError: [Errno 28] No space left on device\n\n",
            RenderError,
            "(exit code 1), saying: OSError: [Errno 28] No space left on device.",
        ),
        ("took too long", "", RenderError, "could not be rendered: took too long."),
    ],
)
def test_each_failure_of_a_rendering_has_its_own_sentence(reason, said, kind, sentence):
    error = render_failure(reason, said)
    assert type(error) is kind
    assert sentence in str(error)
    assert ("libegl1" in str(error)) == (said == NO_EGL)


def own_module(folder, monkeypatch, text):
    """Let a module of this test be run in the place of one that renders."""
    (folder / "renders.py").write_text(text, encoding="utf-8")
    monkeypatch.setenv("PYTHONPATH", str(folder))


def test_a_rendering_that_takes_too_long_is_ended(tmp_path, monkeypatch):
    own_module(tmp_path, monkeypatch, "import time\ndef render(_): time.sleep(60)")
    monkeypatch.setattr(offscreen, "TIME_LIMIT", 0.05)
    process = OffscreenProcess("renders:render", tmp_path)
    with pytest.raises(RenderError, match=r"0\.05 s"):
        process.wait()


def test_what_a_rendering_says_at_its_end_is_passed_on(tmp_path, monkeypatch):
    own_module(tmp_path, monkeypatch, "def render(_): raise OSError(28, 'No space left on device')")
    with pytest.raises(RenderError, match=r"rendered: "):
        OffscreenProcess("renders:render", tmp_path).wait()


@pytest.mark.slow
def test_a_rendering_ends_with_an_owner_that_is_killed(own, tmp_path, monkeypatch):
    """Even where a library keeps Python's threads from running."""
    text = "import ctypes\ndef render(_): open('begun', 'w').close(); ctypes.PyDLL(None).sleep(60)"
    own_module(tmp_path, monkeypatch, text)
    owner = own(
        "from pathlib import Path; from crankfem.analyses.throw.pictures.offscreen import OffscreenProcess\n"
        "OffscreenProcess('renders:render', Path('.')).wait()"
    )
    owner.wait_for((tmp_path / "begun").exists)
    assert len(owner.children()) == 1
    assert owner.end() == ([], [])


TORQUE = data_folder() / "tables" / "yamz5340_torque_one_throw.csv"
SIX = input_path("6chn25-34")


@dataclass(frozen=True)
class Command:
    """A command line.

    Attributes
    ----------
    source : Path
        Shipped file that it reads, as a copy.
    words : tuple of str
        The line, with {mine} for that copy.
    output : str
        A file that it writes.
    """

    source: os.PathLike
    words: tuple
    output: str


COMMANDS = {
    "check": Command(SIX, ("check", "{mine}", "--picture", "throw.svg"), "throw.svg"),
    "draw": Command(SIX, ("draw", "{mine}", "--output", "throw.svg"), "throw.svg"),
    "draw by default": Command(SIX, ("draw", "{mine}"), "mine-throw.svg"),
    "draw png": Command(SIX, ("draw", "{mine}", "--output", "throw.png"), "throw.png"),
    "draw pdf": Command(SIX, ("draw", "{mine}", "--output", "throw.pdf"), "throw.pdf"),
    "harmonics": Command(TORQUE, ("harmonics", "{mine}", "--csv", "out.csv"), "out.csv"),
    "harmonics pictures": Command(
        TORQUE, ("harmonics", "{mine}", "--pictures", "plots"), "plots/torque.svg"
    ),
    "harmonics of an engine": Command(
        SIX, ("harmonics", "{mine}", "--pictures", "plots"), "plots/stars.svg"
    ),
    "mechanism": Command(SIX, ("mechanism", "{mine}", "--csv", "out.csv"), "out.csv"),
    "mechanism pictures": Command(
        SIX, ("mechanism", "{mine}", "--pictures", "plots"), "plots/crankpin_polar.svg"
    ),
    **{name: Command(*case) for name, case in of_satellites("WRITES").items()},
    "vibration": Command(SIX, ("vibration", "{mine}", "--csv", "tables"), "tables/torsional.csv"),
    "vibration pictures": Command(
        SIX, ("vibration", "{mine}", "--pictures", "plots"), "plots/axial_modes.svg"
    ),
    "stress": Command(SIX, ("stress", "{mine}", "--pictures", "plots"), "plots/stress-axial.png"),
    "export solid": Command(SIX, ("export", "{mine}", "throw.step"), "throw.step"),
    "export mesh": Command(
        SIX, (*["export", "{mine}", "a.msh", "--part", "quarter", "--size", "8"],), "a.msh"
    ),
    "export vtu": Command(
        SIX, (*["export", "{mine}", "a.vtu", "--part", "quarter", "--size", "8"],), "a.vtu"
    ),
    "export deck": Command(
        SIX, (*["export", "{mine}", "a.inp", "--calculix", "--size", "8"],), "a.inp"
    ),
    "fit": Command(None, ("fit", "{mine}"), "model.json"),
    "fit --model": Command(None, ("fit", "{mine}", "--model", "a.json"), "a.json"),
    "fit --plots": Command(
        None, ("fit", "{mine}", "--plots", "plots"), "plots/axial_compliance_parity.svg"
    ),
}


@pytest.fixture(scope="module")
def vibration_as_run(coarse_throw):
    @cache
    def run():
        engine, analysis = coarse_throw("6chn25-34")
        return engine_vibration(engine, analysis=analysis)

    return run


@pytest.fixture
def calculated(lightly_stressed, monkeypatch, vibration_as_run):
    """Let commands give what was calculated once: files are what is looked at."""
    calculate_satellites_once(monkeypatch)
    put_everywhere(monkeypatch, engine_vibration, lambda *_, **__: vibration_as_run())


# Commands that take more than half a second each.
LONG = ("vibration", "vibration pictures", "stress", "export deck", "fit --plots")


@pytest.fixture(
    params=[
        pytest.param(name, marks=[pytest.mark.further] if name in LONG else []) for name in COMMANDS
    ]
)
def line(request, tmp_path, calculated):
    """A command line with its input, and the path of its output."""
    command = COMMANDS[request.param]
    if command.source is None:
        mine = request.getfixturevalue("store")
    else:
        mine = tmp_path / f"mine{command.source.suffix}"
        shutil.copy(command.source, mine)
    words = [word.format(mine=mine.name) for word in command.words]
    output = tmp_path / command.output
    output.parent.mkdir(exist_ok=True)
    return words, output, mine


@pytest.fixture
def lightly_stressed(coarsely, monkeypatch):
    """Pictures of stresses that show nothing, in no time."""

    class Empty:
        def __init__(self, _, folder, arrays):
            for name in arrays["files"]:
                (folder / str(name)).write_bytes(b"a picture")

        def wait(self):
            pass

    monkeypatch.setattr(stress_picture, "OffscreenProcess", Empty)


@pytest.mark.further
def test_a_file_gives_way_only_if_the_command_made_it(line, call):
    words, output, _ = line

    def refused():
        before = output.read_bytes()
        answer = call(*words)
        assert (answer.code, answer.out) == (2, "")
        assert answer.err.startswith("Error: ")
        assert answer.err.count("\n") == 1
        for part in (output.name, "--force"):
            assert part in answer.err
        assert output.read_bytes() == before

    output.write_text("precious", encoding="utf-8")
    refused()
    # After that the same line works again and again.
    for options in (("--force",), ()):
        answer = call(*words, *options)
        assert answer.code == 0, answer.err
    assert output.read_bytes() not in (b"precious", b"")
    output.write_bytes(output.read_bytes() + b"\n# mine")
    refused()


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "last"),
    [
        ("harmonics of an engine", "plots/stars.svg"),
        ("mechanism pictures", "plots/piston_forces.svg"),
        *of_satellites("LAST_FILES").items(),
        ("fit --plots", "plots/axial_compliance_sensitivities.svg"),
    ],
)
def test_nothing_is_written_where_the_last_file_is_refused(name, last, call, tmp_path, request):
    command = COMMANDS[name]
    mine = request.getfixturevalue("store") if command.source is None else command.source
    (tmp_path / last).parent.mkdir()
    (tmp_path / last).write_text("precious", encoding="utf-8")
    before = [path.name for path in sorted(tmp_path.rglob("*")) if path.is_file()]
    answer = call(*(word.format(mine=mine) for word in command.words))
    assert (answer.code, answer.out) == (2, "")
    there = [path.name for path in sorted(tmp_path.rglob("*")) if path.is_file()]
    assert [name for name in there if not name.startswith("runs.sqlite-")] == before


@pytest.mark.slow
def test_an_input_stays_even_if_forced(line, call):
    words, output, mine = line
    before = mine.read_bytes()
    link = os.link if len(output.name) % 2 else os.symlink  # one rule: half of the commands each
    link(mine, output)
    for options in ((), ("--force",)):
        answer = call(*words, *options)
        assert (answer.code, answer.out) == (2, "")
        assert answer.err.count("\n") == 1
        assert mine.read_bytes() == before


def test_another_store_is_no_model_either(store, call, tmp_path):
    shutil.copy(store, tmp_path / "other.sqlite")
    assert call("fit", store.name, "--model", "other.sqlite", "--force").code == 2
    assert (tmp_path / "other.sqlite").read_bytes() == store.read_bytes()


def test_two_outputs_are_two_files(call, tmp_path):
    answer = call("draw", "6chn25-34", "--output", "a.png", "--picture", "./a.png")
    assert (answer.code, answer.out) == (2, "")
    assert answer.err.startswith("Error: --picture: given a.png")
    assert list(tmp_path.iterdir()) == []


def test_python_writes_by_the_same_rules(model_file, tmp_path):
    model = ComplianceModel.load(model_file)
    mine = tmp_path / "mine.csv"
    mine.write_text("precious", encoding="utf-8")
    with pytest.raises(cf.InputError, match=r"mine\.csv: "):
        model.save(mine)
    assert mine.read_text(encoding="utf-8") == "precious"
    with cf.replacing_files():
        model.save(mine)
    model.save(mine)
    assert ComplianceModel.load(mine) == model
    plot = tmp_path / "plot.svg"
    plot.write_text("precious", encoding="utf-8")
    with (
        pytest.raises(cf.InputError, match=r"plot\.svg: "),
        figure(plot) as axes,
    ):
        axes.plot([0.0, 1.0])
    assert plot.read_text(encoding="utf-8") == "precious"


@pytest.mark.slow
@pytest.mark.parametrize(
    "name",
    [
        *("results.json", "report.html", "model.json", "throw.vtu"),
        *("pictures/drawing.svg", "pictures/axial_modes.json", "study.sqlite"),
    ],
)
@pytest.mark.parametrize("folder", [".", "mine-results"])
def test_a_run_refuses_what_is_in_its_way_before_it_computes(
    call, tmp_path, monkeypatch, quick_six, name, folder
):
    def computed(*_, **__):
        raise AssertionError("nothing is computed for it")

    monkeypatch.setattr("crankfem.jobs.pipeline.analyze_throws", computed)
    (tmp_path / "mine.toml").write_text(quick_six, encoding="utf-8")
    file = tmp_path / folder / name
    file.parent.mkdir(parents=True, exist_ok=True)
    file.write_text("precious", encoding="utf-8")
    before = sorted(tmp_path.rglob("*"))
    answer = call("run", "mine.toml", "--output", folder, "-q")
    assert (answer.code, answer.out) == (2, "")
    assert answer.err.count("\n") == 1
    assert file.name in answer.err
    assert file.read_text(encoding="utf-8") == "precious"
    assert sorted(tmp_path.rglob("*")) == before


@pytest.mark.further
def test_a_run_in_the_folder_of_its_file_leaves_the_rest(coarsely, call, tmp_path, least_engine):
    (tmp_path / "mine.toml").write_text(least_engine, encoding="utf-8")
    # The file that fit writes by default; a run without a study writes none.
    (tmp_path / "model.json").write_text("precious", encoding="utf-8")
    (tmp_path / "report.html").write_text("precious", encoding="utf-8")
    for options, code in ((), 2), (("--force",), 0), ((), 0):
        answer = call("run", "mine.toml", "--output", ".", *options)
        assert answer.code == code, answer.err
        assert (tmp_path / "model.json").read_text(encoding="utf-8") == "precious"
    assert "<html" in (tmp_path / "report.html").read_text(encoding="utf-8")


def test_with_the_traceback_asked_for_it_is_shown(pictures, monkeypatch, capsys):
    pictures.attempt("picture", picture_fail)
    assert "Traceback" not in capsys.readouterr().err
    monkeypatch.setenv("CRANKFEM_TRACEBACK", "1")
    pictures.attempt("picture", picture_fail)
    assert "Traceback" in capsys.readouterr().err
