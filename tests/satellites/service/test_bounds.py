"""Who may ask, how much, how slowly."""

import http.client
import json
import os
import socket
import subprocess
import sys
import time
from concurrent.futures import ThreadPoolExecutor
from contextlib import ExitStack
from pathlib import Path
from urllib.parse import quote

import psutil
import pytest

from crankbase.errors import MOST_TOLD, InputError
from crankfem.client import Client, RefusedError
from crankfem.satellites.service.command import _read_key
from crankfem.satellites.service.guard import Settings
from refusals import refused
from satellites.service.serving import ROOT, Served

KEY = "a key of twenty chars"


@pytest.fixture(scope="module")
def locked(tmp_path_factory):
    """A service with a key."""
    folder = tmp_path_factory.mktemp("locked")
    (folder / "key").touch(0o600)
    (folder / "key").write_text(f"{KEY}\n")
    with Served(folder, "--key-file", str(folder / "key")) as served:
        yield served


def test_other_machines_need_a_key():
    for field, options in (
        ("--host", {"host": "0.0.0.0"}),
        ("key", {"host": "0.0.0.0", "key": "short"}),
        ("--host", {"host": "", "key": KEY}),
        ("--port", {"port": 70000}),
    ):
        with refused(field):
            Settings(Path(), **options)
    assert Settings(Path(), host="0.0.0.0", key=KEY).key == KEY


@pytest.mark.further
def test_the_service_says_whom_it_serves(service):
    assert "(this machine alone)" in service.log.read_text()


@pytest.mark.further
def test_without_the_key_nothing_is_answered(locked):
    status, told = locked.json("/api/jobs")
    assert status == 401
    for path in ("/api", "/api/", "/api/health", "/api/openapi.json", "/api/none"):
        assert locked.ask(path)[0] == 401
    assert told["title"] == "Unauthorized"
    assert locked.ask("/api/jobs", Authorization="Bearer wrong")[0] == 401
    assert locked.ask("/api/jobs", Cookie=f"crankfem_session={KEY}; =;")[0] == 401
    assert Client(locked.address, KEY).jobs() == []
    assert locked.ask("/")[0] == 200  # the page asks for the key


def test_the_page_brings_the_key_as_a_cookie_that_scripts_do_not_see(locked):
    assert locked.json("/api/session", {"key": "wrong"})[0] == 401
    status, headers, _ = locked.ask("/api/session", {"key": KEY})
    assert status == 200
    cookie = headers["Set-Cookie"]
    assert "HttpOnly" in cookie
    assert "SameSite=strict" in cookie
    assert KEY not in cookie
    assert quote(KEY) not in cookie
    assert locked.ask("/api/jobs", Cookie=cookie.partition(";")[0])[0] == 200


@pytest.mark.parametrize(
    "headers",
    [
        *({"Origin": origin} for origin in ("https://example.org", "null")),
        {"Sec_Fetch_Site": "cross-site"},
        *({"Host": host} for host in ("example.org", "127.0.0.1.example.org:8765", "[::1")),
        *({"Host": host} for host in ("127.0.0.1@example.org", "localhost:9001@example.org")),
        *({"Host": host} for host in ("[::1]example.org", "[::1]:80.example.org", "localhost/x")),
    ],
)
def test_foreign_origins_are_refused(service, headers):
    assert service.ask("/api/jobs", **headers)[0] in (400, 403)
    assert service.ask("/api/throws/validate", {"throw": {}}, **headers)[0] in (400, 403)


def test_its_own_origin_and_names_are_answered(service):
    assert service.ask("/api/jobs", Origin=service.address)[0] == 200
    for name in ("localhost", "LOCALHOST:80", "[::1]", "[::1]:80", "127.0.0.1:"):
        assert service.ask("/api/jobs", Host=name)[0] == 200


@pytest.mark.parametrize(
    ("body", "status"),
    [
        (b"", 400),
        (b"[1]", 400),
        (b'{"throw": NaN}', 400),
        (b'{"throw": ' + b"[" * 400, 400),
        (b'{"throw": ' + b"[" * 40_000, 413),
        (b'{"throw": [' + b'"",' * 30_000 + b'""]}', 413),
        (b"\xff\xfe", 400),
        (b'{"throw": {"crank_radius": 1e999}}', 422),
        (b'{"throw": {"crank_radius": ' + b"9" * 5000 + b"}}", 400),
    ],
)
def test_malformed_bodies_are_refused(service, body, status):
    found, headers, told = service.ask("/api/throws/validate", body)
    assert found == status
    assert headers["Content-Type"] == "application/problem+json"
    assert json.loads(told)["status"] == found


def test_other_media_are_refused(service):
    status, _, _ = service.ask("/api/throws/validate", b"{}", Content_Type="text/plain")
    assert status == 415


def raw(service, *parts, pause=0.0):
    """Send bytes as they are, and return what is answered until the end."""
    host, _, port = service.address.removeprefix("http://").partition(":")
    with socket.create_connection((host, int(port)), timeout=60) as connection:
        for part in parts:
            connection.sendall(part)
            time.sleep(pause)
        found = b""
        while piece := connection.recv(65536):
            found += piece
        return found


def test_large_bodies_are_refused_before_they_are_read(service):
    head = b"POST /api/throws/validate HTTP/1.1\r\nHost: localhost\r\nContent-Type: application/json\r\n"
    assert raw(service, head + b"Content-Length: 99999999999\r\n\r\n").startswith(b"HTTP/1.1 413")
    chunk = b"40000\r\n" + b" " * 0x40000 + b"\r\n"
    chunked = head + b"Transfer-Encoding: chunked\r\nConnection: close\r\n\r\n"
    try:
        told = raw(service, chunked, *[chunk] * 130, b"0\r\n\r\n")
    except OSError:  # refused while it was still sent
        told = b"HTTP/1.1 413"
    assert told.startswith(b"HTTP/1.1 413")


MOST = 100_000  # bytes


@pytest.fixture(scope="module", params=["httptools", "h11"])
def small(request, tmp_path_factory):
    """A service with a key and a low limit, under each parser of requests."""
    folder = tmp_path_factory.mktemp(request.param)
    hidden = ["httptools"] if request.param == "h11" else []
    with Served(folder, key=KEY, hidden=hidden, body=MOST, small_body=MOST) as served:
        yield served


def posted(service, headers, body, path="/api/throws/validate", key=KEY):
    """Send a request with these headers, and return its status; 0 for a connection that was closed."""
    head = f"POST {path} HTTP/1.1\r\nHost: localhost\r\nContent-Type: application/json\r\n"
    head += f"Connection: close\r\nAuthorization: Bearer {key}\r\n" if key else ""
    try:
        told = raw(
            service, (head + "".join(f"{one}\r\n" for one in headers) + "\r\n").encode(), body
        )
    except OSError:  # closed while it was still sent
        return 0
    return int(told.split()[1])


def question(size):
    """A body of so many bytes, refused (422) if it is read."""
    return b'{"throw": {}}'.ljust(size)


def chunked(body):
    return b"%x\r\n%s\r\n0\r\n\r\n" % (len(body), body)


@pytest.mark.further
def test_bodies_are_counted_as_they_come_under_both_parsers(small):
    """Whatever a request says of its length; a connection that is closed on who still sends is a refusal."""
    short, long = question(20), question(3 * MOST)
    told, pieces = "Content-Length: 20", "Transfer-Encoding: chunked"
    assert posted(small, [told], short) == 422
    assert posted(small, [pieces], chunked(short)) == 422
    assert posted(small, [f"Content-Length: {len(long)}"], b"") == 413
    assert posted(small, [pieces], chunked(long)) in (413, 0)
    for body in (short, long):
        for pair in ([told, pieces], [pieces, told], [pieces, "Content-Length: 0"]):
            assert posted(small, pair, chunked(body)) in (400, 0)
    for pair in ([told, "Content-Length: 21"], [told, "Host: localhost"], [told, "host: evil"]):
        assert posted(small, pair, short) in (400, 0)
    assert posted(small, [pieces, pieces], chunked(short)) in (400, 0)
    assert small.json("/api", Authorization=f"Bearer {KEY}")[0] == 200


@pytest.mark.slow
def test_without_the_key_nothing_of_a_body_is_kept(small):
    process = psutil.Process(small.process.pid)
    posted(small, ["Content-Length: 10"], b" " * 10, key="")
    before = process.memory_info().rss
    large = 20_000_000
    for headers, body in (
        ([f"Content-Length: {MOST}"], b" " * large),
        (["Transfer-Encoding: chunked"], chunked(question(large))),
        (["Content-Length: 5", "Transfer-Encoding: chunked"], chunked(question(large))),
    ):
        assert posted(small, headers, body, key="") in (400, 401, 0)
        assert posted(small, headers, body, "/api/session", key="") in (400, 413, 0)
    assert process.memory_info().rss - before < 2_000_000


@pytest.mark.further
def test_slow_heads_and_bodies_are_refused(serve, tmp_path):
    service = serve(tmp_path, seconds=0.5)
    start = time.monotonic()
    heads = [
        b"POST /api/throws/law HTTP/1.1\r\nHost: localhost\r\nContent-Type: application/json\r\n"
    ]
    heads.append(heads[0].replace(b"law", b"validate"))
    slow = [(heads[0], b"")]
    slow += [(head + b"Content-Length: 100\r\n\r\n", b'{"throw"') for head in heads]
    with ThreadPoolExecutor() as pool:
        answers = list(pool.map(lambda parts: raw(service, *parts), slow))
    assert time.monotonic() - start < 10.0
    for told in answers:
        assert told.startswith(
            b"HTTP/1.1 408 Request Timeout\r\nContent-Type: application/problem+json"
        )
        assert json.loads(told.partition(b"\r\n\r\n")[2])["status"] == 408
    deadline = time.monotonic() + 10.0  # the lines follow the answers
    while service.log.read_text().count('"status":408') < 2:
        assert time.monotonic() < deadline
        time.sleep(0.01)
    assert "Traceback" not in service.log.read_text()


def patiently(service, path, **headers):
    """Ask as a client that heeds Retry-After, for 10 s; return the last status."""
    deadline = time.monotonic() + 10.0
    while True:
        status, answered, _ = service.ask(path, **headers)
        if status != 503 or time.monotonic() > deadline:
            return status
        time.sleep(int(answered["Retry-After"]))


@pytest.mark.further
def test_connections_beyond_the_limit_are_refused_until_others_close(serve, tmp_path):
    """Those that have brought the key are kept, even while nothing is asked."""
    service = serve(tmp_path, connections=2, key=KEY)
    port = int(service.address.rpartition(":")[2])
    asked = f"GET /api HTTP/1.1\r\nHost: localhost\r\nAuthorization: Bearer {KEY}\r\n\r\n"
    with ExitStack() as held:
        for _ in range(2):
            kept = held.enter_context(socket.create_connection(("127.0.0.1", port)))
            kept.sendall(asked.encode())
            assert kept.recv(1000).startswith(b"HTTP/1.1 200")
        key = {"Authorization": f"Bearer {KEY}"}
        status, headers, told = service.ask("/api/throws/law", {"throw": {}}, **key)
        assert status == json.loads(told)["status"] == 503
        assert json.loads(told)["detail"] == "Too many connections are open; try again later."
        assert headers["Content-Type"] == "application/problem+json"
        assert int(headers["Retry-After"]) > 0
        assert headers["X-Content-Type-Options"] == "nosniff"
    assert patiently(service, "/api/jobs", **key) == 200
    assert 503 in [
        json.loads(line)["status"]
        for line in service.log.read_text().splitlines()[1:]
        if "{" in line
    ]


LARGEST = "/page/plotly.js"


def silent_reader(service, held):
    """Ask for the largest file, and read nothing of it."""
    reader = held.enter_context(socket.socket())
    reader.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
    reader.connect(("127.0.0.1", int(service.address.rpartition(":")[2])))
    reader.sendall(f"GET {LARGEST} HTTP/1.1\r\nHost: localhost\r\n\r\n".encode())
    return reader


@pytest.mark.slow
def test_those_who_read_nothing_make_room_for_others(serve, tmp_path):
    service = serve(tmp_path, connections=8, key=KEY)
    process = psutil.Process(service.process.pid)
    assert service.ask(LARGEST)[0] == 200
    before = process.memory_info().rss
    with ExitStack() as held:
        for _ in range(24):
            silent_reader(service, held)
        # Those whose answer is still being made do not make room yet: the refusal asks for another try.
        assert patiently(service, "/api", Authorization=f"Bearer {KEY}") == 200
        assert len(process.net_connections()) <= 8 + 1
    assert process.memory_info().rss - before < 10_000_000


@pytest.mark.further
@pytest.mark.parametrize("pause", [None, 0.05])
def test_an_answer_that_is_not_read_is_dropped_in_time(serve, tmp_path, pause):
    """Also one of which a few bytes are read now and then."""
    service = serve(tmp_path, seconds=0.5)
    process = psutil.Process(service.process.pid)
    with ExitStack() as held:
        reader = silent_reader(service, held)
        deadline = time.monotonic() + 30.0
        while any(kept.status == "ESTABLISHED" for kept in process.net_connections()):
            assert time.monotonic() < deadline
            if pause is not None:
                try:
                    reader.recv(1)
                except ConnectionResetError:
                    break
            time.sleep(pause or 0.05)
    assert service.ask(LARGEST)[0] == 200


@pytest.mark.slow
def test_a_log_that_nobody_reads_stops_nothing(tmp_path):
    """A pipe holds 64 kB, some 600 lines."""
    command = [sys.executable, "-P", "-m", "crankfem", "serve", "--json", "--port", "0"]
    with subprocess.Popen(
        [*command, "--folder", str(tmp_path / "service")],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        env=os.environ
        | {"PYTHONPATH": os.pathsep.join([str(ROOT), os.environ.get("PYTHONPATH", "")])},
    ) as process:
        try:
            told = b""
            while b"}" not in told:
                told += process.stdout.readline()
            address = json.loads(told)["address"].removeprefix("http://").rstrip("/")
            asked = http.client.HTTPConnection(address, timeout=60)
            for _ in range(1500):
                asked.request("GET", "/api")
                assert asked.getresponse().read()
            process.terminate()
            process.wait(timeout=60)  # and it ends
        finally:
            process.kill()


def test_jobs_are_read_by_their_user_alone(service):
    folder = service.folder / "service"
    for place in (folder, folder / "jobs", folder / "jobs.sqlite"):
        assert place.stat().st_mode & 0o077 == 0, place


def test_a_key_that_others_can_read_is_refused(tmp_path):
    key = tmp_path / "key"
    key.write_text(KEY)
    key.chmod(0o640)
    with pytest.raises(InputError, match="chmod 600"):
        _read_key(key)
    key.chmod(0o600)
    assert _read_key(key) == KEY


def test_of_many_errors_the_first_are_told_and_how_many_more(service, throw):
    names = {f"name_{place}": 1 for place in range(3000)}
    for asked in ({"throw": throw | names}, {"throw": throw} | names):
        status, told = service.json("/api/throws/validate", asked)
        assert status == 422
        assert len(told["errors"]) == MOST_TOLD + 1
        assert str(3000 - MOST_TOLD) in told["errors"][-1]["message"]


@pytest.mark.parametrize("name", ["further_pins", "oil_holes"])
def test_lists_of_a_throw_are_short(service, throw, name):
    status, told = service.json("/api/throws/law", {"throw": throw | {name: [{}] * 60}})
    assert status == 422
    (error,) = told["errors"]
    assert error["field"] == f"throw.{name}"
    assert "a list of 60 tables" in error["message"]


def test_nonsense_on_the_line_is_refused(service):
    head, _, told = raw(service, b"\x16\x03\x01\x02\x00\x01\r\n\r\n").partition(b"\r\n\r\n")
    assert head.startswith(
        b"HTTP/1.1 400 Bad Request\r\nContent-Type: application/problem+json\r\n"
    )
    assert json.loads(told)["detail"] == "The request is not HTTP/1.1."
    assert service.ask("/api/jobs")[0] == 200


@pytest.mark.slow
@pytest.mark.parametrize(
    "wrong",
    [
        *({"name": name} for name in ("../mine.toml", "/tmp/mine.toml", ".crankfem.toml")),
        *({"name": name} for name in ("mine.toml\n", "mine.csv")),
        *({"tables": {name: "1"}} for name in ("../table.csv", "a/b.csv", "engine.toml")),
        *({"tables": {name: "1"}} for name in ("a\0.csv", "..\\a.csv", "C:a.csv", "..%2fa.csv")),
        *({"tables": {name: "1"}} for name in ("\uff0e\uff0e\uff0fa.csv", f"{'a' * 77}.csv")),
        {"tables": {"a.csv\n": "1"}},
        {"tables": {f"{place}.csv": "1" for place in range(201)}},
        {"text": "\ud800"},
    ],
)
def test_uploaded_files_have_plain_names(service, wrong):
    status, told = service.json("/api/files/check", {"text": "[throw]"} | wrong)
    assert status in (400, 422)
    reasons = ("plain name", "name of the file itself", "allowed are 200", "hex escape")
    assert any(reason in told["detail"] for reason in reasons), told


def test_a_refused_method_names_all_that_the_path_takes(service):
    """Two functions answer at this path."""
    status, headers, _ = service.ask("/api/jobs/0", method="PUT")
    assert (status, headers["Allow"]) == (405, "DELETE, GET")


def test_scripts_in_a_file_stay_text(service):
    text = '[engine]\nname = "<script>alert(1)</script>"\n'
    status, headers, body = service.ask("/api/files/check", {"text": text})
    assert status == 422
    assert headers["Content-Type"] == "application/problem+json"
    assert headers["X-Content-Type-Options"] == "nosniff"
    assert b"/tmp" not in body


def test_each_request_has_one_log_line_without_contents(service):
    before = len(service.log.read_text().splitlines())
    service.ask("/api/throws/validate?secret=1", {"throw": {"crank_radius": "123.456 mm"}})
    lines: list[str] = []
    for _ in range(100):  # the line follows the response
        lines = service.log.read_text().splitlines()[before:]
        if any('"/api/throws/validate"' in line and line.endswith("}") for line in lines):
            break
        time.sleep(0.05)
    (told,) = [json.loads(line) for line in lines if '"/api/throws/validate"' in line]
    assert told["method"] == "POST"
    assert told["status"] == 422
    assert told["milliseconds"] > 0.0
    assert not any(word in "".join(lines) for word in ("secret", "123.456"))


def started(*command):
    """Run a command that does not start a service; return its exit code and what it says."""
    done = subprocess.run([sys.executable, *map(str, command)], capture_output=True, text=True)
    return done.returncode, " ".join(done.stderr.split())


SERVE = ("-m", "crankfem", "serve")


@pytest.mark.further
def test_neither_a_folder_nor_a_port_that_another_service_uses_is_taken(service, tmp_path):
    folder, port = service.folder / "service", service.address.rpartition(":")[2]
    for options, told in (
        (("--folder", folder, "--port", "0"), "which no other service uses"),
        (("--folder", tmp_path, "--port", port), "cannot be listened at"),
    ):
        code, said = started(*SERVE, *options)
        assert code == 2
        assert told in said


@pytest.mark.slow
def test_without_the_extra_the_command_says_which_one(tmp_path):
    script = (
        "import sys; sys.modules |= dict.fromkeys(('uvicorn', 'starlette', 'fastapi'));"
        "from crankfem.cli.entry import main; main()"
    )
    code, said = started("-c", script, "serve", "--folder", tmp_path)
    assert code == 3
    assert "pip install 'crankfem[serve]'" in said


def test_a_refusal_of_the_client_has_its_status(locked):
    with pytest.raises(RefusedError, match="key of this service") as caught:
        Client(locked.address).models()
    assert caught.value.status == 401
