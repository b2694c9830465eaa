"""Faults around the service: killed, its worker killed, its disk full; headers in pairs; many followers."""

import http.client
import json
import selectors
import signal
import socket
import sys
import threading
import time
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager, suppress
from functools import partial
from itertools import product
from pathlib import Path
from random import Random
from urllib.error import URLError

import psutil
from fault_disk import mounted
from fault_tools import HANGS, Bench, Finding, kill, rows, workers

sys.path.append(str(Path(__file__).resolve().parents[1]))
from satellites.service.serving import THROW, Served, save_model

ENDED = ("done", "failed", "canceled")
JOB = {"throw": THROW, "accuracy": 0.01}
LONG_JOB = {"throw": THROW, "accuracy": 0.002}


@contextmanager
def _service(folder: Path, finding: Finding, *options: str, **bounds: object) -> Iterator[Served]:
    """A service that must end without a traceback."""
    folder.mkdir(parents=True, exist_ok=True)
    with Served(folder, *options, **bounds) as service:
        yield service
        if service.end() not in (0, -signal.SIGTERM):
            finding.silent += 1
            finding.says(f"service ended with {service.process.returncode}")
        if "Traceback" in (log := service.log.read_text()):
            finding.tracebacks += 1
            finding.says(log[log.index("Traceback") :][-600:])


def _submitted(service: Served, finding: Finding) -> str | None:
    """Submit a job; refused, it must leave a sentence and nothing else."""
    place, before = service.folder / "service" / "jobs", service.json("/api/jobs")[1]["jobs"]
    folders = set(place.iterdir())
    status, told = service.json("/api/throws/analysis", JOB)
    if status == 202:
        return str(told["id"])
    left = set(place.iterdir()) - folders
    known = {job["id"] for job in before}
    left |= {job["id"] for job in service.json("/api/jobs")[1]["jobs"] if job["id"] not in known}
    if left or status not in (503, 507) or not told["detail"]:
        finding.silent += 1
        finding.says(f"submitting: {status} {told}, left behind: {left}")
    finding.says(told["detail"])
    return None


def _await_jobs(service: Served, names: list[str], finding: Finding) -> None:
    """All jobs end, failed ones with their reason; another one is done then, and nothing is wrong."""
    for name in names:
        job = service.wait(name, *ENDED, seconds=HANGS)
        if job["state"] == "failed":
            finding.says(job["problem"]["detail"])
            finding.lost += job["problem"]["status"] != 507 and "was lost" not in str(
                job["problem"]
            )
    name = _submitted(service, finding)
    if name is None or service.wait(name, *ENDED, seconds=HANGS)["state"] != "done":
        finding.lost += 1
        finding.says("no job is done afterwards")
    deadline = time.monotonic() + 90.0
    while service.json("/api/health")[1]["state"] != "ok":
        if time.monotonic() > deadline:
            finding.hangs += 1
            finding.says(str(service.json("/api/health")))
            return
        time.sleep(0.2)


def disk_full(bench: Bench, draw: Random, store: Path) -> Finding:
    """Fill the disk of a service with jobs in its queue: before one runs, while it does, at its end."""
    finding = Finding()
    for moment in ("before", "during", "recording"):
        folder = store.with_suffix("") / moment
        folder.mkdir(parents=True)
        with mounted(folder / "service", 30_000) as disk, _service(folder, finding) as service:
            names = [str(service.json("/api/throws/analysis", JOB)[1]["id"]) for _ in range(3)]
            if moment != "before":
                service.wait(names[0], "running", *ENDED)
                time.sleep(draw.uniform(0.0, 2.0) if moment == "during" else 0.0)
            while moment == "recording" and not (disk / "jobs" / names[0] / "throw.step").exists():
                time.sleep(0.001)
            with suppress(OSError), (disk / "fill").open("wb", buffering=0) as fill:
                while True:
                    fill.write(b" " * 4096)
            finding.inputs += 1
            told, deadline = False, time.monotonic() + 20.0
            while not told and time.monotonic() < deadline:
                told = service.json("/api/health")[1]["problems"] != []
                time.sleep(0.1)
            if not told and service.json("/api/health")[1]["queued"]:
                finding.silent += 1
                finding.says("jobs wait, and nothing says why")
            names += filter(None, [_submitted(service, finding)])
            asked = {
                "law": service.ask("/api/throws/law", {"throw": THROW})[0],
                "cancel": service.ask(f"/api/jobs/{names[-1]}/cancel", {})[0],
                "jobs": service.ask("/api/jobs")[0],
            }
            if asked["law"] != 200 or asked["jobs"] != 200 or asked["cancel"] == 500:
                finding.silent += 1
                finding.says(str(asked))
            time.sleep(draw.uniform(0.0, 4.0))
            (disk / "fill").unlink()
            _await_jobs(service, names, finding)
    return finding


def worker_killed(bench: Bench, draw: Random, store: Path) -> Finding:
    """Kill what runs the jobs of a service, also while it is loading, with others in the queue."""
    finding = Finding()
    with _service(store.with_suffix(""), finding) as service:
        names = [str(service.json("/api/throws/analysis", JOB)[1]["id"]) for _ in range(3)]
        for _ in range(3):
            time.sleep(draw.uniform(0.0, 4.0))
            for child in workers(service.process):
                with suppress(psutil.NoSuchProcess):
                    child.kill()
                    finding.inputs += 1
        _await_jobs(service, names, finding)
    return finding


KEY, MOST = "a key of twenty chars", 100_000
KEPT = 20e6  # bytes, of 500 MB offered
LENGTHS = ("0", "5", "20", "300000", "-1", "+20", "5, 20", "20, 20", "0x14", "", "9" * 30)
CODINGS = ("chunked", "Chunked", "identity", "gzip, chunked", "chunked, identity", "xchunked", "")
HEADERS = (
    *(f"Content-Length: {one}" for one in LENGTHS),
    *(f"Transfer-Encoding: {one}" for one in CODINGS),
    *(f"Host: {one}" for one in ("localhost", "evil", "localhost@evil", "[::1]evil", "")),
    "Authorization: Bearer wrong",
    "Origin: null",
    "Expect: 100-continue",
    "Connection: Upgrade\r\nUpgrade: websocket",
    "Content-Length : 20",
    "X: 1\r\n Content-Length: 5",
)
# Wrong, so that 422 says that it was read.
SHORT = b'{"throw": {}}'.ljust(20)
LONG = b'{"throw": {}}'.ljust(3 * MOST)


def _status(port: int, head: bytes, body: bytes) -> int:
    """Status of the answer; 0 where the connection was closed on who still sent."""
    told = b""
    with suppress(ConnectionError), socket.create_connection(("127.0.0.1", port), 60.0) as line:
        line.sendall(head + body)
        while piece := line.recv(65536):
            told += piece
    told = told.removeprefix(b"HTTP/1.1 100 Continue\r\n\r\n")
    return int(told.split()[1]) if told.startswith(b"HTTP/1.1 ") else 0


def header_pairs(bench: Bench, draw: Random, store: Path) -> Finding:
    """Give two headers that may contradict each other, under both parsers of requests."""
    finding = Finding()
    for hidden in ((), ("httptools",)):
        folder = store.with_suffix("") / "_".join(("hidden", *hidden))
        with _service(folder, finding, key=KEY, hidden=hidden, body=MOST, seconds=0.3) as service:
            port = int(service.address.rpartition(":")[2])
            process, kept = psutil.Process(service.process.pid), []
            # Without the key nothing more is kept than the parsers took before.
            for has_key in (True, False):
                with ThreadPoolExecutor(8) as pool:
                    told = list(pool.map(partial(_pair, port, has_key), product(HEADERS, HEADERS)))
                kept.append(process.memory_info().rss)
                finding.inputs += len(told)
                for text in filter(None, told):
                    finding.silent += 1
                    finding.says(text)
            if kept[1] - kept[0] > KEPT:
                finding.silent += 1
                finding.says(f"{(kept[1] - kept[0]) / 1e6:.0f} MB are kept")
    return finding


def _pair(port: int, has_key: bool, given: tuple[str, str]) -> str | None:
    """Send a pair with short, long and chunked bodies, with the key or without; return what is wrong."""
    first, second = given
    key = f"Authorization: Bearer {KEY}\r\n" if has_key else ""
    host = "" if "Host" in first else "Host: localhost\r\n"
    head = f"POST /api/throws/validate HTTP/1.1\r\n{host}Content-Type: application/json\r\n{key}"
    if "Upgrade" not in first + second:
        head += "Connection: close\r\n"
    lines = [one.partition(": ") for one in (*head.split("\r\n")[1:-1], first, second)]
    lengths = {
        one for name, _, told in lines if name == "Content-Length" for one in told.split(", ")
    }
    names = [name for name, _, _ in lines if name in ("Host", "Transfer-Encoding", "Authorization")]
    clear = has_key and len(set(names)) == len(names) and len(lengths) < 2
    clear = clear and not (lengths and "Transfer-Encoding" in names)
    for body in (
        SHORT,
        LONG,
        b"14\r\n%s\r\n0\r\n\r\n" % SHORT,
        b"%x\r\n%s\r\n" % (len(LONG), LONG),
    ):
        try:
            status = _status(port, f"{head}{first}\r\n{second}\r\n\r\n".encode(), body)
        except TimeoutError:
            return f"{first}, {second}: no answer"
        read = status == 422
        if status // 100 not in (0, 4) or (
            read and not (clear and (len(body) < MOST or lengths == {"20"}))
        ):
            return f"{first}, {second}, {len(body)} bytes, {has_key}: {status}"
    return None


FOLLOWERS, ASKED, SLOWER = 400, 200, 2.5


def followers(bench: Bench, draw: Random, store: Path) -> Finding:
    """Follow jobs by many streams: the law answers about as fast, and each stream is told of the end."""
    finding = Finding(inputs=FOLLOWERS)
    told = [b""] * FOLLOWERS
    with (
        _service(store.with_suffix(""), finding) as service,
        selectors.DefaultSelector() as streams,
    ):
        names = [str(service.json("/api/throws/analysis", LONG_JOB)[1]["id"]) for _ in range(4)]
        service.wait(names[0], "running")
        port = int(service.address.rpartition(":")[2])
        _mean(port)
        alone = _mean(port)
        for place in range(FOLLOWERS):
            line = socket.create_connection(("127.0.0.1", port), 60.0)
            path = f"/api/jobs/{draw.choice(names)}/events"
            line.sendall(
                f"GET {path} HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n\r\n".encode()
            )
            streams.register(line, selectors.EVENT_READ, place)

        def read() -> None:
            while streams.get_map():
                for key, _ in streams.select(1.0):
                    piece = key.fileobj.recv(65536)
                    told[key.data] += piece
                    if not piece:
                        streams.unregister(key.fileobj)
                        key.fileobj.close()

        reader = threading.Thread(target=read, daemon=True)
        reader.start()
        time.sleep(2.0)
        beside = _mean(port)
        for name in reversed(names):
            service.ask(f"/api/jobs/{name}/cancel", {})
        reader.join(60.0)
        finding.hangs += len(streams.get_map() or ())
        finding.lost += sum(b'"canceled"' not in text and b'"done"' not in text for text in told)
    finding.says(f"law: {alone:.2f} ms alone, {beside:.2f} ms beside {FOLLOWERS} followers")
    finding.hangs += beside > SLOWER * alone
    return finding


def _mean(port: int) -> float:
    """Mean time of an answer by the law [ms]."""
    line, text = http.client.HTTPConnection("127.0.0.1", port), json.dumps({"throw": THROW})
    began = time.perf_counter()
    for _ in range(ASKED):
        line.request("POST", "/api/throws/law", text, {"Content-Type": "application/json"})
        line.getresponse().read()
    line.close()
    return 1e3 * (time.perf_counter() - began) / ASKED


# Seconds of the service's processor for one request, and until its health is answered beside it.
MOST_WORK, MOST_WAIT = 1.0, 0.2
HELD, HELD_SECONDS = 500, 120.0


def _heavy_requests() -> Iterator[tuple[str, bytes]]:
    """Yield paths and bodies that take long, up to the limits of size."""
    law, check, lookup = "/api/throws/law", "/api/files/check", "/api/models/six/lookup"
    between = {"gamma_deg": 0.01, "left_gamma_deg": 0.013, "pin_force": [0.0, -1e5, 0.0]}
    names = {f"name_{place}": 1 for place in range(6000)}
    pins = [{"length": 0.139}] * 5000
    questions: list[tuple[str, dict[str, object]]] = [
        (law, {"throw": THROW, "ranges": True, "slopes": True}),
        (law, {"throw": THROW, "support": "neighbors"} | between),
        (law, {"throw": THROW | {"further_pins": pins}}),
        (law, {"throw": THROW | names}),
        (law, {"throw": THROW} | names),
        ("/api/throws/outline", {"throw": THROW, "letters": True}),
        ("/api/throws/formulas", {"throw": THROW}),
        (check, {"text": "[throw]\n" + "\n".join(f"{name} = 1" for name in names)}),
        (check, {"text": "[throw]\n" + "\n".join(["[[throw.further_pins]]"] * 20_000)}),
        (check, {"text": "[throw]", "tables": {f"{name}.csv": "1" for name in names}}),
        (lookup, {"dimensions": {name: [size] * 100_000 for name, size in THROW.items()}}),
        (
            lookup,
            {"dimensions": {"web_thickness": [f"{60 + 1e-3 * at} mm" for at in range(24_000)]}},
        ),
        (lookup, {"dimensions": {"web_thickness": [1] * 100_000}}),
    ]
    yield from ((path, json.dumps(question).encode()) for path, question in questions)
    for path in (law, check, lookup):
        for part in (b"[]", b"{}", b"1", b'""', b'{"a":[0]}'):
            yield path, b'{"throw": [' + b",".join([part] * (7_000_000 // (len(part) + 1))) + b"]}"
        yield path, b"{" + b",".join(b'"%d":1' % place for place in range(600_000)) + b"}"


def heavy_requests(bench: Bench, draw: Random, store: Path) -> Finding:
    """Ask what takes longest: it is answered or refused in little work, and health is answered beside it."""
    finding = Finding()
    models = store.with_suffix("") / "models"
    models.mkdir(parents=True)
    save_model(models)
    with _service(store.with_suffix(""), finding, "--models", str(models)) as service:
        process, ended, waits = psutil.Process(service.process.pid), threading.Event(), [0.0]

        def ask_health() -> None:
            while not ended.wait(0.02):
                began = time.perf_counter()
                service.ask("/api/health")
                waits[0] = max(waits[0], time.perf_counter() - began)

        beside = threading.Thread(target=ask_health, daemon=True)
        service.ask("/api/throws/outline", {"throw": THROW})  # loads what draws
        beside.start()
        for path, body in _heavy_requests():
            waits[0], before = 0.0, sum(process.cpu_times()[:2])
            status = 413  # the service closes on who still sends what is too large
            with suppress(URLError):
                status = service.ask(path, body)[0]
            work = sum(process.cpu_times()[:2]) - before
            finding.inputs += 1
            finding.says(
                f"{path} {len(body) / 1e6:.2f} MB: {status}, {work:.2f} s of the processor, "
                f"health in {waits[0]:.2f} s"
            )
            finding.hangs += work > MOST_WORK or waits[0] > MOST_WAIT or status >= 500
        ended.set()
        beside.join()
    return finding


def silent_readers(bench: Bench, draw: Random, store: Path) -> Finding:
    """Ask for the largest file on all connections, again and again, and read nothing; a key is served."""
    finding = Finding()
    with _service(store.with_suffix(""), finding, key=KEY, workers=1) as service:
        address = ("127.0.0.1", int(service.address.rpartition(":")[2]))
        held: list[socket.socket] = []
        ends, slowest, dropped = time.monotonic() + HELD_SECONDS, 0.0, 0
        while time.monotonic() < ends:
            kept = [
                line for line in held if line.getsockopt(socket.SOL_SOCKET, socket.SO_ERROR) == 0
            ]
            dropped, held = dropped + len(held) - len(kept), kept
            while len(held) < HELD:
                held.append(line := socket.socket())
                line.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
                line.connect(address)
                line.sendall(b"GET /page/plotly.js HTTP/1.1\r\nHost: localhost\r\n\r\n")
            began = time.perf_counter()
            status, _, _ = service.ask("/api", Authorization=f"Bearer {KEY}")
            slowest = max(slowest, time.perf_counter() - began)
            finding.inputs += 1
            finding.lost += status != 200
            time.sleep(0.2)
        for line in held:
            line.close()
        memory = psutil.Process(service.process.pid).memory_info().rss
        finding.says(
            f"{dropped} dropped; slowest answer with the key {slowest:.2f} s; memory {memory / 1e6:.0f} MB"
        )
    return finding


def server(bench: Bench, draw: Random, store: Path) -> Finding:
    """Kill the service while it runs a study as a job; the next service on its folder goes on with it."""
    finding = Finding()
    folder = store.parent / f"{store.stem}-service"
    folder.mkdir(exist_ok=True)
    service = Served(folder)
    text = bench.file.read_text(encoding="utf-8")
    _, told = service.json("/api/studies", {"text": text, "name": "study.toml"})
    before: dict[str, dict[str, object]] = {}
    own = next(iter((folder / "service" / "jobs").iterdir()))

    def found() -> Path:
        return next(iter(own.glob("**/*.sqlite")), own / "none")

    for _ in range(2):  # a third time the job would count as what ends the service
        time.sleep(draw.uniform(0.0, bench.seconds))
        if service.json(f"/api/jobs/{told['id']}")[1]["state"] == "done":
            break
        kill(service.process, finding)
        finding.inputs += 1
        bench.judge(found(), finding, before)
        before = rows(found())
        service = Served(folder)
    job = service.wait(told["id"], "done", "failed", seconds=400.0)
    if job["state"] != "done":
        finding.lost += 1
        finding.says(str(job["problem"]))
    finding.says(" ".join(job["notes"]))
    if service.end() not in (0, -signal.SIGTERM):
        finding.silent += 1
        finding.says(f"service ended with {service.process.returncode}")
    finding.tracebacks += "Traceback" in service.log.read_text()
    bench.judge(found(), finding, before)
    if len(rows(found())) != bench.wanted:
        finding.lost += 1
    return finding
