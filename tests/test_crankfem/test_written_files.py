"""What each command that writes does to files that are there: its own, somebody else's, its inputs."""

import os
import shutil
from dataclasses import dataclass
from functools import cache

import pytest

import crankfem as cf
from crankbase.drawing.diagram_style import figure
from crankbase.outputs import LISTED
from crankfem.analyses.hinge.hinge_run import run_hinge
from crankfem.analyses.throw.pictures import stress_picture
from crankfem.analyses.vibration.run import engine_vibration
from crankfem.files.hinge_file import load_hinge
from crankfem.files.reading.data_files import data_folder, input_path
from regression.models.compliance_model import ComplianceModel
from stand_ins import put_everywhere

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
    "hinge": Command(
        input_path("crosshead-30-100", "hinge"), ("hinge", "{mine}", "--csv", "out.csv"), "out.csv"
    ),
    "hinge pictures": Command(
        input_path("crosshead-30-100", "hinge"),
        ("hinge", "{mine}", "--pictures", "p"),
        "p/hinge_speed.svg",
    ),
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


@cache
def hinge_as_run():
    return run_hinge(load_hinge("crosshead-30-100"))


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
    put_everywhere(monkeypatch, run_hinge, lambda *_: hinge_as_run())
    put_everywhere(monkeypatch, engine_vibration, lambda *_, **__: vibration_as_run())


# Commands that take more than a second each.
LONG = ("vibration", "vibration pictures", "stress", "export deck", "fit --plots")


@pytest.fixture(
    params=[
        pytest.param(name, marks=[pytest.mark.slow] if name in LONG else []) for name in COMMANDS
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


@pytest.mark.slow
def test_a_file_gives_way_only_if_the_command_made_it(line, call):
    words, output, _ = line

    def refused(reason):
        before = output.read_bytes()
        answer = call(*words)
        assert (answer.code, answer.out) == (2, "")
        assert answer.err.startswith("Error: ")
        assert answer.err.count("\n") == 1
        for part in (output.name, reason, "--force"):
            assert part in answer.err
        assert output.read_bytes() == before

    model = words[0] == "fit" and output.suffix == ".json"
    unknown = "it is not an unchanged model made by crankfem" if model else None
    output.write_text("precious", encoding="utf-8")
    refused(unknown or "crankfem has not made it")
    # After that the same line works again and again.
    for options in (("--force",), ()):
        answer = call(*words, *options)
        assert answer.code == 0, answer.err
    assert output.read_bytes() not in (b"precious", b"")
    output.write_bytes(output.read_bytes() + b"\n# mine")
    refused(unknown or "it was changed since crankfem wrote it")


@pytest.mark.parametrize(
    ("name", "last"),
    [
        ("harmonics of an engine", "plots/stars.svg"),
        ("mechanism pictures", "plots/piston_forces.svg"),
        ("hinge pictures", "p/hinge_guides.svg"),
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
    assert "crankfem has not made it" in answer.err
    there = [path.name for path in sorted(tmp_path.rglob("*")) if path.is_file()]
    assert [name for name in there if not name.startswith("runs.sqlite-")] == before


@pytest.mark.parametrize("link", [os.link, os.symlink], ids=["hard link", "link"])
def test_an_input_stays_even_if_forced(line, call, link):
    words, output, mine = line
    before = mine.read_bytes()
    link(mine, output)
    for options in ((), ("--force",)):
        answer = call(*words, *options)
        assert (answer.code, answer.out) == (2, "")
        assert answer.err.count("\n") == 1
        assert mine.read_bytes() == before


def test_a_store_is_no_model(store, call):
    before = store.read_bytes()
    for options in ((), ("--force",)):
        answer = call("fit", store.name, "--model", f"./{store.name}", *options)
        assert (answer.code, answer.out) == (2, "")
        assert "because this command reads that file" in answer.err
        assert store.read_bytes() == before


def test_another_store_is_no_model_either(store, call, tmp_path):
    shutil.copy(store, tmp_path / "other.sqlite")
    answer = call("fit", store.name, "--model", "other.sqlite", "--force")
    assert answer.code == 2
    assert (tmp_path / "other.sqlite").read_bytes() == store.read_bytes()


def test_a_model_needs_no_list(store, call, tmp_path):
    assert call("fit", store.name).code == 0
    assert not (tmp_path / LISTED).exists()
    assert call("fit", store.name).code == 0
    text = (tmp_path / "model.json").read_text(encoding="utf-8")
    (tmp_path / "model.json").write_text(text.replace("e_n", "e_m"), encoding="utf-8")
    assert call("fit", store.name).code == 2


def test_two_outputs_are_two_files(call, tmp_path):
    answer = call("draw", "6chn25-34", "--output", "a.png", "--picture", "./a.png")
    assert (answer.code, answer.out) == (2, "")
    assert "--picture: given a.png, which --output writes too" in answer.err
    assert list(tmp_path.iterdir()) == []


def test_new_replaces_a_file_only_if_forced(call, tmp_path):
    assert call("new", "mine.toml").code == 0
    assert sorted(path.name for path in tmp_path.iterdir()) == ["mine.toml"]
    answer = call("new", "mine.toml", "--from", "6chn25-34")
    assert answer.code == 2
    assert "--force" in answer.err
    assert call("new", "mine.toml", "--from", "6chn25-34", "--force").code == 0
    assert (tmp_path / "mine.toml").read_bytes() == SIX.read_bytes()
    (tmp_path / "link.toml").symlink_to(tmp_path / "nowhere")
    assert call("new", "link.toml").code == 2


def test_python_writes_by_the_same_rules(model_file, tmp_path):
    model = ComplianceModel.load(model_file)
    mine = tmp_path / "mine.csv"
    mine.write_text("precious", encoding="utf-8")
    with pytest.raises(cf.InputError, match=r"mine\.csv: is not replaced, because"):
        model.save(mine)
    assert mine.read_text(encoding="utf-8") == "precious"
    with cf.replacing_files():
        model.save(mine)
    model.save(mine)
    assert ComplianceModel.load(mine) == model
    plot = tmp_path / "plot.svg"
    plot.write_text("precious", encoding="utf-8")
    with (
        pytest.raises(cf.InputError, match=r"plot\.svg: is not replaced, because"),
        figure(plot) as axes,
    ):
        axes.plot([0.0, 1.0])
    assert plot.read_text(encoding="utf-8") == "precious"


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


@pytest.mark.slow
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
