"""Requests a second of the service, their ratio to an empty FastAPI route, and the times of its page.

    python benchmarks/load_service.py [--seconds 30] [--page]

Fifty clients ask for laws and lookups of ever different throws; in turns with them, the same clients ask
an application of the same server that has one empty route, so that what else the machine does falls on
both. With --page a browser moves a slider and calculates a throw. Times are of this machine.
"""

import argparse
import asyncio
import json
import random
import re
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

CLIENTS = 50
ROUND = 5.0  # seconds of one turn
EMPTY = """
import sys, uvicorn
from fastapi import FastAPI
app = FastAPI()
@app.get("/")
async def nothing():
    return None
uvicorn.run(app, port=int(sys.argv[1]), log_level="error", access_log=False, ws="none",
            proxy_headers=False, server_header=False, limit_concurrency=500)
"""
EMPTY_PORT = 8799


def request(path: str, question: Any = None) -> bytes:
    body = b"" if question is None else json.dumps(question).encode()
    method = "GET" if question is None else "POST"
    head = f"{method} {path} HTTP/1.1\r\nHost: localhost\r\nContent-Type: application/json\r\n"
    return f"{head}Content-Length: {len(body)}\r\n\r\n".encode() + body


def law() -> bytes:
    from satellites.service.serving import THROW

    throw = THROW | {
        "web_width": random.uniform(0.27, 0.33),
        "pin_length": random.uniform(0.12, 0.15),
    }
    return request("/api/throws/law", {"throw": throw})


def lookup() -> bytes:
    asked = {"dimensions": {"web_thickness": random.uniform(0.046, 0.089)}}
    return request("/api/models/six/lookup", asked)


def mixed() -> bytes:
    return law() if random.random() < 0.5 else lookup()


def nothing() -> bytes:
    return request("/")


async def load(port: int, make: Any, seconds: float) -> tuple[list[float], int]:
    """Ask with all clients; return the times of answers [s], and how many were no success."""
    times: list[float] = []
    errors = 0
    end = time.perf_counter() + seconds

    async def client() -> None:
        nonlocal errors
        reader, writer = await asyncio.open_connection("127.0.0.1", port)
        while time.perf_counter() < end:
            start = time.perf_counter()
            writer.write(make())
            head = await reader.readuntil(b"\r\n\r\n")
            length = re.search(rb"content-length: (\d+)", head, re.IGNORECASE)
            await reader.readexactly(int(length[1]) if length else 0)
            times.append(time.perf_counter() - start)
            errors += b" 200 " not in head[:20]
        writer.close()

    await asyncio.gather(*(client() for _ in range(CLIENTS)))
    return times, errors


def told(name: str, rates: list[float], times: list[float], errors: int) -> None:
    p99 = 1e3 * statistics.quantiles(times, n=100)[-1]
    print(
        f"{name:24} {statistics.median(rates):8.0f} requests/s  p99 {p99:6.1f} ms  {errors} errors"
    )


async def measure(port: int, seconds: float) -> None:
    kinds = {"empty FastAPI route": (EMPTY_PORT, nothing), "laws and lookups": (port, mixed)}
    kinds |= {"laws alone": (port, law), "lookups alone": (port, lookup)}
    found: dict[str, tuple[list[float], list[float], int]] = {name: ([], [], 0) for name in kinds}
    for _ in range(max(1, round(seconds / ROUND))):
        for name, (own, make) in kinds.items():
            times, errors = await load(own, make, ROUND)
            rates, all_times, before = found[name]
            found[name] = ([*rates, len(times) / ROUND], all_times + times, before + errors)
    for name, values in found.items():
        told(name, *values)
    empty, ours = (found[name][0] for name in list(kinds)[:2])
    shares = [own / other for own, other in zip(ours, empty, strict=True)]
    print(f"ratio to the empty route: {statistics.median(shares):.2f}, in pairs of {ROUND:g} s")


def measure_rows(address: str) -> None:
    from crankfem.client import Client

    rows = [0.046 + 4e-7 * place for place in range(100_000)]
    for count, responses in ((1, ["axial_compliance"]), (2, None)):
        taken = []
        for _ in range(5):
            start = time.perf_counter()
            Client(address)._ask(  # the time of the service, not of reading its answer
                "models/six/lookup", {"dimensions": {"web_thickness": rows}, "responses": responses}
            )
            taken.append(time.perf_counter() - start)
        print(
            f"100,000 rows of {count} response{'s' * (count > 1)}: {statistics.median(taken):.2f} s"
        )


def measure_page(address: str) -> None:
    import shutil

    from playwright.sync_api import sync_playwright

    flags = [
        "--no-sandbox",
        "--use-gl=angle",
        "--use-angle=swiftshader",
        "--enable-unsafe-swiftshader",
    ]
    with sync_playwright() as started:
        browser = started.chromium.launch(executable_path=shutil.which("chromium"), args=flags)
        page = browser.new_page()
        page.goto(address)
        page.wait_for_selector("body[data-ready]")
        page.wait_for_timeout(3000)
        turns = [page.evaluate(TURN, 0.05 + 0.0005 * place) for place in range(60)]
        print(f"from a slider to new numbers and drawing: {statistics.median(turns):.0f} ms")
        taken = []
        for _ in range(3):
            page.reload()
            page.wait_for_selector("body[data-ready]")
            page.wait_for_timeout(3000)
            start = time.perf_counter()
            page.click(".calculate")
            page.wait_for_selector(".solid.plot-drawn", timeout=60_000)
            taken.append(time.perf_counter() - start)
            page.wait_for_selector(".step:not([disabled])", timeout=60_000)
        print(f"finite elements with the interactive view: {statistics.median(taken):.1f} s")


TURN = """async (place) => {
    const root = document.querySelector(".throw");
    const slider = root.querySelector("#a-web_thickness ~ input[type=range]");
    const before = root.dataset.updated;
    const start = performance.now();
    slider.value = place;
    slider.dispatchEvent(new Event("input", { bubbles: true }));
    while (root.dataset.updated === before) {
        await new Promise((next) => new MutationObserver(next).observe(
            root, { attributes: true, attributeFilter: ["data-updated"] }));
    }
    return performance.now() - start;
}"""


def main() -> None:
    options = argparse.ArgumentParser()
    options.add_argument("--seconds", type=float, default=30.0)
    options.add_argument("--page", action="store_true")
    given = options.parse_args()
    sys.path.insert(0, str(Path(__file__).parents[1] / "tests"))
    from satellites.service.serving import Served, save_model

    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        (folder / "models").mkdir()
        save_model(folder / "models")
        service = Served(folder, "--models", str(folder / "models"))
        empty = subprocess.Popen([sys.executable, "-c", EMPTY, str(EMPTY_PORT)])
        try:
            time.sleep(3.0)
            if given.page:
                measure_page(service.address)
            measure_rows(service.address)
            asyncio.run(measure(int(service.address.rpartition(":")[2]), given.seconds))
        finally:
            empty.kill()
            service.end()


if __name__ == "__main__":
    main()
