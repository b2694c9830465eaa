"""Wrong command lines, tried in this process; nothing is meshed or started."""

import contextlib
import io
import os
import re
import shlex
import shutil
import sys
import warnings
from collections.abc import Iterator
from functools import cache
from pathlib import Path
from typing import Any
from unittest import mock

from hypothesis import strategies as st

import crankbase.processes
import geometry.gmsh_session
from crankbase.errors import MeshError
from crankfem.cli import app as cli
from crankfem.files.satellites import at_place
from satellite_cases import of_satellites
from strategies.files import NUMBERS, ROOT, UNITS, WORDS
from strategies.outcomes import (
    ACCEPTED,
    HANG,
    NOT_FINITE,
    REFUSED,
    TRACEBACK,
    HangError,
    Outcome,
    patience,
    where_raised,
)
from strategies.parsers import CHAIN_TEXTS, RESULTS, STUDIES, THROW, models

NO_NUMBER = re.compile(r"(?<![\w./'\"-])[-+]?(?:nan|inf|infinity)(?![\w./'\"-])", re.IGNORECASE)


def _no_process(*_: Any, **__: Any) -> Any:
    raise MeshError("No process is started here.")


@contextlib.contextmanager
def nothing_started() -> Iterator[None]:
    """Let no mesher, no worker and no server start: what is read and checked before is tried alone."""

    def call(_: Any, function: str, *arguments: Any, **__: Any) -> Any:
        # What a satellite has done elsewhere is tried here.
        own = function.startswith("crankfem.satellites.")
        return at_place(function)(*arguments) if own else _no_process()

    with contextlib.ExitStack() as put:
        put.enter_context(mock.patch.object(geometry.gmsh_session.IsolatedProcess, "call", call))
        put.enter_context(mock.patch.object(geometry.gmsh_session.IsolatedProcess, "start"))
        put.enter_context(mock.patch.object(crankbase.processes.subprocess, "Popen", _no_process))
        for place in of_satellites("STARTS").values():
            put.enter_context(mock.patch(place))
        yield


@cache
def _commands() -> Any:
    """Return the commands, which typer otherwise makes anew for each line."""
    import typer

    return typer.main.get_command(cli.app)


# Command lines.

FILES = {
    "throw.toml": THROW,
    "study.toml": STUDIES[0],
    "chain.txt": CHAIN_TEXTS[0],
    "results.csv": RESULTS[0],
    "broken.toml": THROW[:-20],
    "empty.toml": "",
    "words.csv": "a,b\nc,d\n",
}


def lay_out(folder: Path) -> None:
    """Write the files that command lines name into a folder."""
    for name, text in FILES.items():
        (folder / name).write_text(text, encoding="utf-8")
    (folder / "model.json").write_text(models()[0], encoding="utf-8")
    (folder / "binary.toml").write_bytes(bytes(range(256)))
    (folder / "folder").mkdir(exist_ok=True)
    shutil.copy(ROOT / "data" / "engines" / "6chn25-34.toml", folder / "mine.toml")
    shutil.copy(ROOT / "data" / "tables" / "yamz5340_torque_one_throw.csv", folder / "torque.csv")


NAMES = (
    *FILES, "model.json", "binary.toml", "folder", "mine.toml", "torque.csv", "no-such.toml",
    "6chn25-34", "yamz-5340",
    "8chn26-26", "buick-3800", "12chn18-20", "mwm-six", "crosshead-30-100", "law", "5rt-flex50d",
)  # fmt: skip
ASSIGNED = (
    "web_width=300mm",
    "web_thickness=60 mm",
    "web_thickness=",
    "=3",
    "pin_length=1e99 mm",
    "x=y",
    "web_thickness=nan",
)


def _examples() -> list[list[str]]:
    listed = [examples for _, _, examples in cli.places().values()]
    return [shlex.split(text) for examples in listed for text in examples] + [
        shlex.split(text)
        for text in (
            "lookup law --throw throw.toml --gamma '120 deg'", "lookup model.json web_thickness=60mm",
            "formulas throw.toml --no-fe",
            "mechanism mine.toml --json", "harmonics torque.csv --orders 6 --json",
            "check throw.toml --json", "vibration chain.txt",
            "new other.toml --cylinders 5 --strokes 2", "fields throw", "plan study.toml",
            "two-mass yamz-5340 --json",
            "import study.toml results.csv --alone",
            "optimum model.json --minimize web_thickness", "serve --port 0",
            "stress throw.toml", "export throw.toml throw.msh", "throw mine.toml --gamma '120 deg'",
            "run mine.toml",
            "fit runs.sqlite", "report folder", "class mine.toml",
            "draw throw.toml throw.svg",
        )
    ]  # fmt: skip


def _options() -> dict[str, list[str]]:
    """Return the options of each command."""
    return {
        name: [
            option
            for one in command.params
            for option in (*one.opts, *one.secondary_opts)
            if option.startswith("-")
        ]
        for name, command in _commands().commands.items()
    }


tokens = st.one_of(
    st.sampled_from(NAMES),
    st.sampled_from([word for word in WORDS if "\0" not in word]),
    st.tuples(st.sampled_from(NUMBERS), st.sampled_from(UNITS)).map(" ".join),
    st.sampled_from(NUMBERS),
    st.sampled_from(ASSIGNED),
    st.text(st.characters(exclude_characters="\0", exclude_categories=("Cs",)), max_size=12),
)


@st.composite
def command_lines(draw: st.DrawFn) -> list[str]:
    """Draw a command line that is nearly right."""
    line = list(draw(st.sampled_from(_EXAMPLES)))
    for _ in range(draw(st.integers(1, 3))):
        kind = draw(
            st.sampled_from(("value", "value", "option", "option", "option", "drop", "twice"))
        )
        place = draw(st.integers(0, 20)) % max(1, len(line))
        if kind == "value" and place:
            line[place] = draw(tokens)
        elif kind == "option" and line and line[0] in _OPTIONS:
            line.append(draw(st.sampled_from(_OPTIONS[line[0]])))
            if draw(st.integers(0, 3)):
                line.append(draw(tokens))
        elif kind == "drop" and line:
            del line[place]
        elif kind == "twice" and line:
            line.insert(place, line[place])
    return [one for one in line if one not in ("--install-completion", "--show-completion")]


_EXAMPLES, _OPTIONS = _examples(), _options()


def run_command(line: list[str], folder: Path) -> Outcome:
    """Run a command line in a folder, and tell what came of it."""
    said, told, code = io.StringIO(), io.StringIO(), 0
    before = Path.cwd()
    os.chdir(folder)
    try:
        with (
            patience(),
            nothing_started(),
            mock.patch.object(sys, "argv", ["crankfem", *line]),
            mock.patch("typer.main.get_command", return_value=_commands()),
            contextlib.redirect_stdout(said),
            contextlib.redirect_stderr(told),
            warnings.catch_warnings(),
        ):
            warnings.simplefilter("ignore")
            warnings.simplefilter("error", RuntimeWarning)
            cli.main()
    except SystemExit as end:
        code = int(end.code or 0)
    except HangError:
        return Outcome(HANG, "took too long")
    except BaseException as error:
        return Outcome(TRACEBACK, where_raised(error))
    finally:
        os.chdir(before)
    out, err = said.getvalue(), told.getvalue()
    if "which nobody expected" in err or "Traceback" in err:
        return Outcome(TRACEBACK, f"{line[:1]}: {err.strip()[-300:]}")
    if code == 0 and line[:1] == ["new"]:
        return Outcome(ACCEPTED)  # it prints the name of the file alone, any word
    if code == 0:
        found = NO_NUMBER.search(out)
        shown = None if found is None else out[max(0, found.start() - 60) : found.end() + 20]
        return Outcome(ACCEPTED) if found is None else Outcome(NOT_FINITE, f"{line[:1]}: {shown}")
    if code in (2, 3, 4, 5) and err.strip():
        return Outcome(REFUSED, err)
    if code == 2 and not line:
        return Outcome(REFUSED)  # with nothing to do, the help is shown
    return Outcome(TRACEBACK, f"{line[:1]}: exit code {code} with {err.strip()[-200:]!r}")
