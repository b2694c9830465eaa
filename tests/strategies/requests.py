"""Wrong command lines and requests to the service, tried in this process; nothing is meshed or started."""

import asyncio
import contextlib
import io
import json
import os
import re
import shlex
import shutil
import sys
import warnings
from collections.abc import Callable, Iterator
from functools import cache
from pathlib import Path
from typing import Any
from unittest import mock

from hypothesis import strategies as st

import crankbase.processes
import crankfem.service.app
import geometry.gmsh_session
from crankbase.errors import MeshError, with_short_quotes
from crankfem.cli import app as cli
from crankfem.service import tasks
from crankfem.service.app import make_app
from crankfem.service.guard import Bounds, Settings
from strategies.files import NUMBERS, ROOT, UNITS, WORDS, changed_json, json_texts, texts_of
from strategies.outcomes import (
    ACCEPTED,
    HANG,
    NOT_FINITE,
    REFUSED,
    TRACEBACK,
    HangError,
    Outcome,
    bad_sentence,
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
        module, name = function.split(":")
        return getattr(tasks, name)(*arguments) if module == tasks.__name__ else _no_process()

    with contextlib.ExitStack() as put:
        put.enter_context(mock.patch.object(geometry.gmsh_session.IsolatedProcess, "call", call))
        put.enter_context(mock.patch.object(geometry.gmsh_session.IsolatedProcess, "start"))
        put.enter_context(mock.patch.object(crankbase.processes.subprocess, "Popen", _no_process))
        put.enter_context(mock.patch.object(crankfem.service.app, "serve"))
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
    listed = [examples for group in cli.COMMANDS.values() for examples in group.values()]
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


# Requests to the service.

STEEL = {"youngs_modulus": "210 GPa", "poisson_ratio": 0.3, "density": 7850.0}
SHAPE = {
    "crank_radius": 0.17, "main_journal_diameter": "220 mm", "pin_diameter": 0.18,
    "main_journal_length": 0.12,
    "pin_length": 0.139, "web_width": 0.285, "web_thickness": "68 mm", "fillet_radius": 0.012,
    "counterweight": {"outer_radius": 0.27, "angle": "120 deg"},
}  # fmt: skip
_FILE = {
    "text": texts_of("data/engines/6chn25-34.toml")[0],
    "name": "mine.toml",
    "tables": {"a.csv": "1,2\n"},
}
_STUDY = {"text": STUDIES[0], "name": "study.toml", "tables": {}}
QUESTIONS: tuple[tuple[str, dict[str, Any]], ...] = (
    (
        "throws/law",
        {
            "throw": SHAPE,
            "material": STEEL,
            "pin_force": [0.0, -1e5, 0.0],
            "support": "neighbors",
            "gamma_deg": 120.0,
        },
    ),
    ("throws/validate", {"throw": SHAPE, "material": STEEL}),
    ("throws/outline", {"throw": SHAPE, "view": "front"}),
    ("throws/formulas", {"throw": SHAPE, "gamma_deg": 120.0}),
    (
        "throws/analysis",
        {
            "throw": SHAPE,
            "gamma_deg": 120.0,
            "pin_force": [1.0, 2.0, 3.0],
            "accuracy": 0.01,
            "stress": True,
        },
    ),
    ("throws/stress", {"throw": SHAPE, "accuracy": 0.05}),
    (
        "models/small/lookup",
        {
            "dimensions": {"web_thickness": "60 mm"},
            "responses": ["axial_compliance"],
            "strict": True,
        },
    ),
    ("models/small/lookup", {"throw": SHAPE, "dimensions": {"web_thickness": [0.05, 0.06, 0.07]}}),
    ("files/check", _FILE),
    ("engines", _FILE),
    ("studies", _STUDY),
    ("session", {"key": "0123456789abcdef"}),
)
PATHS = (
    "", "/jobs", "/jobs/0123456789abcdef", "/jobs/x/result", "/jobs/../files", "/models/small",
    "/models/%00", "/models/none",
    "/jobs/0123456789abcdef/files/..%2f..%2fetc%2fpasswd", "/throws/law?x=1", "/\ud7ff", "/openapi.json",
    "/models/" + "a" * 3000,
)  # fmt: skip
MEDIA = ("application/json", "application/json; charset=utf-16", "text/plain", "", "x" * 300)
Request = tuple[str, str, bytes, dict[str, str]]


@st.composite
def requests(draw: st.DrawFn) -> Request:
    """Draw method, path, body and headers of a request."""
    path, question = draw(st.sampled_from(QUESTIONS))
    method, headers = "POST", {"content-type": "application/json"}
    kind = draw(st.integers(0, 19))
    body = draw(
        changed_json(question).map(json.dumps) if kind > 3 else json_texts(question)
    ).encode("utf-8", "surrogatepass")
    path = f"/api/{path}"
    if kind == 4:
        body = draw(st.binary(max_size=60))
    elif kind == 5:
        headers = {"content-type": draw(st.sampled_from(MEDIA))}
    elif kind == 6:
        method, path = (
            draw(st.sampled_from(("GET", "POST", "DELETE", "PUT"))),
            "/api" + draw(st.sampled_from(PATHS)),
        )
    elif kind == 7:
        body = b'{"throw": ' + b"[" * draw(st.sampled_from((50, 20_000))) + b"]" * 50 + b"}"
    return method, path, body, headers


def asking(folder: Path) -> Callable[[Request], Outcome]:
    """Return what gives a request to a service in this process, whose jobs wait for ever."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        from starlette.testclient import httpx  # or its successor, if that is installed

    (folder / "models").mkdir(exist_ok=True)
    (folder / "models" / "small.json").write_text(models()[0], encoding="utf-8")
    settings = Settings(folder / "jobs", folder / "models", key=None, bounds=Bounds(waiting=10**9))
    transport = httpx.ASGITransport(make_app(settings)[0], raise_app_exceptions=False)
    client = httpx.AsyncClient(transport=transport, base_url="http://127.0.0.1")
    # One loop for all requests.
    loop = asyncio.Runner()

    def ask(request: Request) -> Outcome:
        method, path, body, headers = request
        log = io.StringIO()
        try:
            with (
                patience(),
                nothing_started(),
                contextlib.redirect_stderr(log),
                warnings.catch_warnings(),
            ):
                warnings.simplefilter("ignore")
                warnings.simplefilter("error", RuntimeWarning)
                answer = loop.run(client.request(method, path, content=body, headers=headers))
        except HangError:
            return Outcome(HANG, path)
        except Exception as error:
            return Outcome(TRACEBACK, where_raised(error))
        return _judged(
            path, answer.status_code, answer.headers.get("content-type", ""), answer.content
        )

    return ask


def _judged(path: str, status: int, media: str, content: bytes) -> Outcome:
    if status >= 500:
        return Outcome(TRACEBACK, f"{path}: {status} {content[:300]!r}")
    if "json" not in media:
        return Outcome(ACCEPTED if status < 400 else TRACEBACK, f"{path}: {status} {media}")
    found = json.loads(content, parse_constant=lambda name: [name])
    if "[" in str(NO_NUMBER.search(content.decode())) and status < 400:
        return Outcome(NOT_FINITE, f"{path}: {NO_NUMBER.search(content.decode())}")
    if status < 400:
        return Outcome(ACCEPTED)
    fault = bad_sentence(with_short_quotes(str(found.get("detail", ""))))
    return Outcome(TRACEBACK, f"{path}: {fault}") if fault else Outcome(REFUSED)
