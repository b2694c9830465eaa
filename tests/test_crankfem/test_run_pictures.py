"""Pictures that cannot be made cost themselves alone, and are told of once."""

import pytest

from crankbase.errors import InputError, MissingLibraryError, RenderError
from crankbase.outputs import atomic_file
from crankfem.analyses.throw.pictures import offscreen
from crankfem.analyses.throw.pictures.offscreen import ADVICE, OffscreenProcess, render_failure
from crankfem.jobs.run_drawing import Pictures, Renderings
from crankfem.report.interactive.plot import Plot, Plots


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


def fail(*_):
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
                Plot("b", "", "", lambda path, _: write_half_and_fail(path), lambda _: figure),
                Plot("c", "", "", lambda path, _: write(path), fail),
                Plot("d", "", "", lambda path, _: write(path), needs="gas"),
            )
        ),
        None,
    )
    assert pictures.static == {"a": "a.svg", "c": "c.svg"}
    assert pictures.interactive == {"a": "a.json", "b": "b.json"}
    assert {path.name for path in tmp_path.glob("[!.]*")} == {"a.svg", "c.svg", "a.json", "b.json"}
    assert told == pictures.notes
    first, second = told
    assert first.startswith("There is no picture b: ValueError: no such thing, an unexpected error")
    assert second == "There is no interactive plot c: b.json: No space left on device."


def test_nothing_is_drawn_over_what_is_somebody_elses(tmp_path):
    (tmp_path / "b.svg").write_text("precious", encoding="utf-8")
    plots = Plots(tuple(Plot(name, "", "", lambda path, _: write(path)) for name in "ab"))
    with pytest.raises(InputError, match=r"b\.svg: is not replaced, because"):
        plots.draw(tmp_path, None)
    assert not (tmp_path / "a.svg").exists()


def test_an_interrupt_is_no_picture_that_fails(pictures):
    def interrupt():
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        pictures.attempt("picture", interrupt)


def test_with_the_traceback_asked_for_it_is_shown(pictures, monkeypatch, capsys):
    pictures.attempt("picture", fail)
    assert "Traceback" not in capsys.readouterr().err
    monkeypatch.setenv("CRANKFEM_TRACEBACK", "1")
    pictures.attempt("picture", fail)
    assert "Traceback" in capsys.readouterr().err


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


def test_one_rendering_that_fails_leaves_the_others(pictures, told):
    missing = MissingLibraryError("install it")
    with Renderings() as renderings:
        renderings.start("picture of stresses", {"stress": "x.png"}, fail)
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
    with pytest.raises(RenderError, match=r"took longer than the limit of 0\.05 s"):
        process.wait()


def test_what_a_rendering_says_at_its_end_is_passed_on(tmp_path, monkeypatch):
    own_module(tmp_path, monkeypatch, "def render(_): raise OSError(28, 'No space left on device')")
    with pytest.raises(RenderError, match=r"rendered: OSError: .*No space left"):
        OffscreenProcess("renders:render", tmp_path).wait()


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
