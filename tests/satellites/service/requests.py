"""Wrong requests to the service, tried in this process; nothing is meshed or started."""

import asyncio
import contextlib
import io
import json
import warnings
from collections.abc import Callable
from pathlib import Path
from typing import Any

from hypothesis import strategies as st

from crankbase.errors import with_short_quotes
from crankfem.satellites.service.app import make_app
from crankfem.satellites.service.guard import Bounds, Settings
from strategies.command_lines import NO_NUMBER, nothing_started
from strategies.files import changed_json, json_texts, texts_of
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
from strategies.parsers import STUDIES, models

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
