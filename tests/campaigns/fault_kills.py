"""Faults of processes: killed, hung or out of memory, each at a random moment."""

import json
import os
import resource
import signal
import socket
import subprocess
import sys
import threading
import time
from pathlib import Path
from random import Random

import psutil
from fault_tools import Bench, Ended, Finding, await_end, kill, lost_rows, rows, workers
from study_tools import THROW, environment

from crankbase.errors import MeshError
from geometry.gmsh_session import IsolatedProcess
from geometry.mesher import mesh_isolated

ROOT = Path(__file__).resolve().parents[2]
MOST = 6  # kills in one study


def coordinator(bench: Bench, draw: Random, store: Path) -> Finding:
    """Kill the coordinator until the study is finished all the same."""
    finding = Finding()
    before = {}
    for _ in range(MOST):
        process = bench.doe(store)
        try:
            process.wait(draw.uniform(0.0, bench.seconds))
        except subprocess.TimeoutExpired:
            finding.inputs += 1
        else:
            break
        kill(process, finding)
        bench.judge(store, finding, before)
        before = rows(store)
    bench.complete(store, finding)
    return finding


def interrupted(bench: Bench, draw: Random, store: Path) -> Finding:
    """Interrupt a study as a terminal or a scheduler does, once or twice."""
    finding = Finding()
    for number in (signal.SIGINT, signal.SIGTERM):
        process = bench.doe(
            store,
            start_new_session=True,
            preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL),
        )
        while not _answers_signals(process):
            time.sleep(0.01)
        time.sleep(draw.uniform(0.0, bench.seconds / 3.0))
        children = workers(process)
        for _ in range(draw.choice([1, 2])):
            if process.poll() is None:
                os.killpg(process.pid, number)
                finding.inputs += 1
            time.sleep(draw.uniform(0.0, 0.3))
        bench.end(process, finding)
        await_end(children, finding)
        bench.judge(store, finding, {})
    bench.complete(store, finding)
    return finding


def _answers_signals(process: "subprocess.Popen[str]") -> bool:
    """Whether Python has come so far as to catch SIGTERM."""
    status = Path(f"/proc/{process.pid}/status").read_text().split("SigCgt:")[-1]
    return process.poll() is not None or bool(int(status.split()[0], 16) >> signal.SIGTERM - 1 & 1)


def _attacked_workers(bench, draw, store, finding, attack, *options) -> Ended:
    """Attack random workers at random moments while a study runs."""
    process = bench.doe(store, *options)
    while process.poll() is None and finding.inputs < MOST:
        time.sleep(draw.uniform(0.0, bench.seconds / 3.0))
        there = workers(process)
        if there and process.poll() is None:
            try:
                attack(draw.choice(there))
            except (psutil.Error, OSError):
                continue
            finding.inputs += 1
    return bench.end(process, finding)


def _told(bench: Bench, store: Path, finding: Finding, ended: Ended) -> None:
    """A study ends well whatever became of its workers; a design that is lost has its reason."""
    if ended.code != 0 and finding.good:
        finding.says(ended.errors[-300:])
        finding.silent += 1
    for reason in lost_rows(store):
        finding.says(reason)
    bench.complete(store, finding)


def worker(bench: Bench, draw: Random, store: Path) -> Finding:
    """Kill workers."""
    finding = Finding()
    number = draw.choice([signal.SIGKILL, signal.SIGABRT, signal.SIGSEGV])
    _told(bench, store, finding, _attacked_workers(
        bench, draw, store, finding, lambda one: one.send_signal(number)))  # fmt: skip
    return finding


def worker_memory(bench: Bench, draw: Random, store: Path) -> Finding:
    """Let workers run out of address space in the middle of their work."""
    finding = Finding()

    def starve(one: psutil.Process) -> None:
        most = one.memory_info().vms + draw.randrange(30_000_000)
        one.rlimit(resource.RLIMIT_AS, (most, most))

    _told(bench, store, finding, _attacked_workers(bench, draw, store, finding, starve))
    return finding


def worker_hang(bench: Bench, draw: Random, store: Path) -> Finding:
    """Stop a worker in its work: it is ended by its time limit, and the design is tried again."""
    finding = Finding(inputs=MOST - 1)  # once in a study
    limit = ("--time-limit", "30 s")
    ended = _attacked_workers(
        bench, draw, store, finding, lambda one: one.send_signal(signal.SIGSTOP), *limit
    )
    finding.inputs -= MOST - 1
    _told(bench, store, finding, ended)
    return finding


def _mesher(draw: Random, number: signal.Signals, limit: float) -> Finding:
    """Send a signal to the mesher at a random moment of its work."""
    finding = Finding(inputs=1)
    process = IsolatedProcess()
    whole = mesh_isolated(THROW, process=process)
    owner = psutil.Process().children()
    began = time.monotonic()
    mesh_isolated(THROW, process=process)
    seconds = time.monotonic() - began
    (child,) = [one for one in owner if "crankbase.calls" in one.cmdline()]
    timer = threading.Timer(draw.uniform(0.0, seconds), lambda: child.send_signal(number))
    timer.start()
    began = time.monotonic()
    try:
        mesh = mesh_isolated(THROW, process=process, time_limit=limit)
    except MeshError as error:
        finding.says(str(error))
    else:
        for attempt in mesh.attempts:
            finding.says(attempt)
        changed = mesh.points.tobytes() != whole.points.tobytes()
        finding.silent += changed and not mesh.attempts
    finding.hangs += time.monotonic() - began > 10.0 * (limit + seconds) + 60.0
    timer.join()  # no part of the attack may hit the mesh that judges it
    again = mesh_isolated(THROW, process=process)
    finding.lost += again.points.tobytes() != whole.points.tobytes()
    process.close()
    return finding


def mesher_killed(_bench: Bench, draw: Random, _store: Path) -> Finding:
    """Kill the mesher, or let it abort."""
    return _mesher(draw, draw.choice([signal.SIGKILL, signal.SIGABRT]), 60.0)


def mesher_hang(_bench: Bench, draw: Random, _store: Path) -> Finding:
    """Stop the mesher in its work."""
    return _mesher(draw, signal.SIGSTOP, 10.0)


def coordinators(bench: Bench, draw: Random, store: Path) -> Finding:
    """Run two studies on one store, of which one may be killed: no design is computed twice."""
    finding = Finding(inputs=1)
    first = bench.doe(store, "--workers", 1)
    time.sleep(draw.uniform(0.0, bench.seconds / 2.0))
    second = bench.doe(store, "--workers", 1)
    if draw.random() < 0.5:
        time.sleep(draw.uniform(0.0, bench.seconds))
        kill(first, finding)
        listed = [bench.end(second, finding)]
    else:
        listed = [bench.end(first, finding), bench.end(second, finding)]
        computed = sum(json.loads(one.out)["computed_now"] for one in listed if one.code == 0)
        if computed != bench.wanted:
            finding.silent += 1
            finding.says(f"{computed} designs computed of {bench.wanted}")
    finding.lost += any(one.code != 0 for one in listed)
    bench.complete(store, finding)
    return finding


# Dask: a scheduler and two workers, each a process of its own.


def _dask(kind: str, folder: Path, *options: str) -> "subprocess.Popen[str]":
    return subprocess.Popen(
        [sys.executable, "-m", f"distributed.cli.dask_{kind}", "--no-dashboard", *options],
        env=environment(),
        cwd=folder,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
        text=True,
    )


def _dask_attack(bench: Bench, draw: Random, store: Path, *, victim: str) -> Finding:
    finding = Finding()
    port = _free_port()
    address = f"tcp://127.0.0.1:{port}"
    folder = store.parent / f"{store.stem}-dask"
    folder.mkdir(exist_ok=True)

    def start_worker() -> "subprocess.Popen[str]":
        return _dask("worker", folder, address, "--nthreads=1", "--no-nanny")

    scheduler = _dask("scheduler", folder, "--host=127.0.0.1", f"--port={port}")
    there = [start_worker(), start_worker()]
    time.sleep(4.0)
    process = bench.doe(store, "--dask", address)
    try:
        if victim == "scheduler":
            time.sleep(draw.uniform(0.3, 1.3) * bench.seconds)
            finding.inputs += process.poll() is None
            scheduler.kill()
        else:
            for _ in range(MOST):
                time.sleep(draw.uniform(0.0, bench.seconds / 2.0))
                if process.poll() is not None:
                    break
                place = draw.randrange(2)
                kill(there[place], finding)
                finding.inputs += 1
                there[place] = start_worker()
        ended = bench.end(process, finding)
        if victim == "worker":
            finding.lost += ended.code != 0
        for reason in lost_rows(store):
            finding.says(reason)
    finally:
        for one in (*there, scheduler):
            one.kill()
            one.wait()
    bench.complete(store, finding)  # on this machine: what the cluster computed is used
    return finding


def _free_port() -> int:
    with socket.socket() as one:
        one.bind(("127.0.0.1", 0))
        return int(one.getsockname()[1])


def dask_worker(bench: Bench, draw: Random, store: Path) -> Finding:
    """Kill Dask workers; others take their places."""
    return _dask_attack(bench, draw, store, victim="worker")


def dask_scheduler(bench: Bench, draw: Random, store: Path) -> Finding:
    """Kill the Dask scheduler."""
    return _dask_attack(bench, draw, store, victim="scheduler")
