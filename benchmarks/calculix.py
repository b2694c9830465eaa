"""A throw by crankfem and by CalculiX: seconds and memory to the same accuracy, and on one mesh.

Run by hand: ``python benchmarks/calculix.py [PAIRS]`` (about ten minutes for 5 pairs); it needs ccx
on PATH and Linux, and prints Markdown tables.

1. Pairs, one after the other in one warm process: (a) `cf.analyze_throw`, asked as little as keeps e_n
   within a true error, which gives the whole 12 x 12 stiffness, masses and error bars; (b) e_n alone by
   CalculiX on a whole throw, meshed as coarsely as keeps e_n within the same error. Both times begin with
   the throw's dimensions.
2. e_n alone to 1 % in a fresh process.
3. One mesh of a whole throw with 300,000 unknowns: our 12 x 12 and CalculiX's axial load case, each in
   a fresh process.

CalculiX runs with one and with two threads of its solver beforehand, and then with what was faster.
"""

import json
import math
import os
import pickle
import resource
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from statistics import median

import crankfem as cf
from calculix_run import read_calculix, run_calculix
from fem.analysis import analyze_axial
from fem.calculix import axial_case, write_calculix
from fem.solver import assemble_stiffness
from fem.superelement import combine_classes, condense
from fem.supports import class_axial_compliances, support_throw
from fem.symmetry import axial_class, symmetry_classes, unit_pin_loads
from geometry.gmsh_session import shared_process
from geometry.mesh import ThrowMesh
from geometry.mesher import mesh_isolated
from geometry.sizes import predict_unknowns

THROW = cf.CrankThrow(
    crank_radius=0.170,
    main_journal_diameter=0.220,
    pin_diameter=0.180,
    main_journal_length=0.120,
    pin_length=0.139,
    web_width=0.300,
    web_thickness=0.068,
    fillet_radius=0.012,
)
ACCURACY = 0.01
# True errors of e_n, and the accuracies of which the least that keeps to one is asked.
ERRORS = (0.008, 0.004, 0.002)
ASKED = (0.04, 0.02, 0.01, 0.007, 0.005, 0.003)
# Converged e_n pinned [m/N]. Quarters with the size factors below (the last has 315,000 unknowns) give
# 1.27776, 1.27928, 1.28000 and 1.28045e-9; the steps shrink by 1.6 to 2.1, so 0.0003 to 0.0007 are left.
# ``python benchmarks/calculix.py reference`` computes them again in two minutes.
CONVERGED = 1.2810e-9
REFERENCE_FACTORS = (0.4, 0.28, 0.2, 0.14)
LARGE = 300_000
TIME_LIMIT = 3600.0


# What is measured.


def axial_alone(throw: cf.CrankThrow) -> float:
    """e_n pinned to 1 %."""
    return analyze_axial(throw, accuracy=ACCURACY).axial_compliance()


def whole_superelement(mesh: ThrowMesh) -> float:
    """e_n pinned by way of the 12 x 12 stiffness of a given mesh, not corrected."""
    stiffness = assemble_stiffness(mesh.points, mesh.elements, cf.STEEL)
    pins = unit_pin_loads(mesh)
    classes = [condense(mesh, stiffness, pins, one) for one in symmetry_classes(mesh.part)]
    return support_throw(combine_classes(classes), "pinned").axial


def quarter_compliance(factor: float) -> float:
    """e_n pinned of a quarter, without an error estimate."""
    mesh = mesh_isolated(THROW, factor, "quarter")
    stiffness = assemble_stiffness(mesh.points, mesh.elements, cf.STEEL)
    part = condense(mesh, stiffness, unit_pin_loads(mesh), axial_class(mesh.part))
    return class_axial_compliances(part, "pinned")[0]


def by_calculix(mesh: ThrowMesh, folder: Path, threads: int) -> tuple[float, float, float]:
    """e_n pinned by CalculiX, seconds to write the deck, and to run and read."""
    start = time.perf_counter()
    deck = write_calculix(mesh, cf.STEEL, folder / "throw.inp", [axial_case()])
    written = time.perf_counter()
    (step,) = read_calculix(run_calculix(deck, threads, TIME_LIMIT))
    return float(step.motions[8]), written - start, time.perf_counter() - written


# How accurate it is.


def print_reference() -> None:
    for factor in REFERENCE_FACTORS:
        print(f"size factor {factor}: {quarter_compliance(factor) * 1e9:.5f}e-9 m/N", flush=True)


def true_error(compliance: float) -> float:
    return abs(compliance / CONVERGED - 1.0)


def coarsest_factor(error: float) -> float:
    """Size factor of the coarsest quarter whose e_n, not corrected, has no larger error, by bisection."""
    fine, coarse = 0.2, 3.0
    for _ in range(8):
        middle = math.sqrt(fine * coarse)
        if true_error(quarter_compliance(middle)) <= error:
            fine = middle
        else:
            coarse = middle
    return fine


def whole_mesh(unknowns: int) -> ThrowMesh:
    """A whole throw with about so many unknowns."""
    factor = factor_of(unknowns)
    found = mesh_isolated(THROW, factor, "full").unknowns
    return mesh_isolated(THROW, factor_of(unknowns * unknowns // found), "full")


def factor_of(unknowns: int) -> float:
    """Size factor of a whole throw for which so many unknowns are predicted."""
    fine, coarse = 0.1, 3.0
    for _ in range(40):
        middle = math.sqrt(fine * coarse)
        if predict_unknowns(THROW.parts, middle, "full") > unknowns:
            fine = middle
        else:
            coarse = middle
    return coarse


# In processes of their own, for the peak of their memory.


STATUS = "/proc/self/status"


def own_peak(lines: list[str]) -> float:
    """Peak memory [MB] from the lines of a process's own `STATUS`.

    `resource.getrusage` would count what the process that started it had before.
    """
    (line,) = (line for line in lines if line.startswith("VmHWM:"))
    return float(line.split()[1]) / 1024.0


def status() -> list[str]:
    return Path(STATUS).read_text().splitlines()


def child_peak() -> float:
    """Peak memory [MB] of the largest child that has ended, if it is larger than this process."""
    return resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss / 1024.0


def timed(work: Callable[[], float]) -> tuple[float, float]:
    start = time.perf_counter()
    value = work()
    return value, time.perf_counter() - start


def measure_axial() -> dict[str, float]:
    mesh_isolated(THROW, 2.5)  # starts the mesher
    before = own_peak(status())
    value, first = timed(lambda: axial_alone(THROW))
    own = own_peak(status())
    mesher = own_peak(shared_process().call("linecache:getlines", STATUS, time_limit=10.0))
    again = median(timed(lambda: axial_alone(THROW))[1] for _ in range(5))
    return {
        "value": value,
        "first": first,
        "again": again,
        "before": before,
        "own": own,
        "mesher": mesher,
    }


def measure_whole(mesh_file: str) -> dict[str, float]:
    mesh = pickle.loads(Path(mesh_file).read_bytes())
    value, seconds = timed(lambda: whole_superelement(mesh))
    return {"value": value, "seconds": seconds, "memory": own_peak(status())}


def measure_calculix(mesh_file: str, threads: str) -> dict[str, float]:
    path = Path(mesh_file)
    mesh = pickle.loads(path.read_bytes())
    value, writing, running = by_calculix(mesh, path.parent, int(threads))
    return {"value": value, "seconds": writing + running, "memory": child_peak()}


ROLES = {"axial": measure_axial, "whole": measure_whole, "calculix": measure_calculix}


def in_fresh_process(*arguments: str) -> dict[str, float]:
    command = [sys.executable, __file__, *arguments]
    done = subprocess.run(command, stdout=subprocess.PIPE, text=True, check=True)
    return json.loads(done.stdout.splitlines()[-1])


# The tables.


def faster_threads(measure: Callable[[int], float], what: str) -> int:
    seconds = {threads: measure(threads) for threads in (1, 2)}
    tried = ", ".join(f"{threads}: {value:.1f} s" for threads, value in seconds.items())
    print(f"CalculiX, threads tried on the {what}: {tried}.", flush=True)
    return min(seconds, key=lambda threads: seconds[threads])


def least_asked(error: float) -> tuple[float, cf.ThrowAnalysis]:
    """The first of the accuracies from which on e_n is within a true error, and its analysis."""
    found = [(asked, cf.analyze_throw(THROW, accuracy=asked)) for asked in ASKED]
    within = [true_error(one.axial_compliance()) <= error for _, one in found]
    first = max((place + 1 for place, own in enumerate(within) if not own), default=0)
    return found[first]


def compare_within_error(error: float, pairs: int, folder: Path) -> None:
    accuracy, analysis = least_asked(error)  # also warms this process
    factor = coarsest_factor(error)
    mesh = mesh_isolated(THROW, factor, "full")
    threads = faster_threads(
        lambda threads: by_calculix(mesh, folder, threads)[2], "mesh of the pairs"
    )
    ours, theirs, parts = [], [], []
    for _ in range(pairs):
        ours.append(timed(lambda: cf.analyze_throw(THROW, accuracy=accuracy).axial_compliance())[1])
        start = time.perf_counter()
        mesh = mesh_isolated(THROW, factor, "full")
        meshed = time.perf_counter() - start
        value, writing, running = by_calculix(mesh, folder, threads)
        parts.append((meshed, writing, running))
        theirs.append(meshed + writing + running)
    ratio = median(theirs) / median(ours)
    meshed, writing, running = (median(column) for column in zip(*parts, strict=True))
    print(f"\n| {pairs} pairs, medians | unknowns | true error of e_n | seconds | ratio |")
    print("|---|---|---|---|---|")
    print(
        f"| (a) analyze_throw to {accuracy:.1%}, whole 12 x 12 ({analysis.mesh.part}) "
        f"| {analysis.mesh.unknowns:,} | {true_error(analysis.axial_compliance()):.2%} "
        f"| {median(ours):.2f} | 1 |"
    )
    print(
        f"| (b) CalculiX, e_n alone, whole throw, size factor {factor:.2f}, {threads} threads "
        f"(mesh {meshed:.2f}, deck {writing:.2f}, ccx {running:.2f}) "
        f"| {mesh.unknowns:,} | {true_error(value):.2%} | {median(theirs):.2f} "
        f"| {ratio:.1f} |"
    )
    print(f"\nSeconds (a): {rounded(ours)}; (b): {rounded(theirs)}.", flush=True)


def print_axial_alone() -> None:
    alone = in_fresh_process("axial")
    print("\n| e_n alone to 1 %, fresh process | true error | seconds | again | MB | mesher MB |")
    print("|---|---|---|---|---|---|")
    print(
        f"| {alone['value'] * 1e9:.4f}e-9 m/N | {true_error(alone['value']):.2%} | {alone['first']:.2f} "
        f"| {alone['again']:.2f} | {alone['own']:.0f} ({alone['before']:.0f} before) "
        f"| {alone['mesher']:.0f} |",
        flush=True,
    )


def compare_on_one_mesh(pairs: int, folder: Path) -> None:
    mesh = whole_mesh(LARGE)
    mesh_file = folder / "large.pickle"
    mesh_file.write_bytes(pickle.dumps(mesh))
    found = {}

    def calculix(threads: int) -> float:
        found[threads] = in_fresh_process("calculix", str(mesh_file), str(threads))
        return found[threads]["seconds"]

    threads = faster_threads(calculix, f"mesh of {mesh.unknowns:,} unknowns")
    ours, theirs = [], [found[threads]]
    for pair in range(pairs):
        ours.append(in_fresh_process("whole", str(mesh_file)))
        if pair:
            theirs.append(in_fresh_process("calculix", str(mesh_file), str(threads)))
    ratios = {
        name: median(their[name] / our[name] for our, their in zip(ours, theirs, strict=True))
        for name in ("seconds", "memory")
    }
    print(f"\n| same mesh, {mesh.unknowns:,} unknowns, {pairs} pairs | e_n | seconds | MB |")
    print("|---|---|---|---|")
    for name, runs in (("whole 12 x 12", ours), (f"CalculiX, e_n, {threads} threads", theirs)):
        seconds, memory = (median(run[key] for run in runs) for key in ("seconds", "memory"))
        print(f"| {name} | {runs[0]['value'] * 1e9:.6f}e-9 | {seconds:.1f} | {memory:.0f} |")
    print(f"| ratio | | {ratios['seconds']:.1f} | {ratios['memory']:.1f} |", flush=True)


def rounded(values: list[float]) -> str:
    return ", ".join(f"{value:.2f}" for value in values)


def main(pairs: int = 5) -> None:
    load = os.getloadavg()[0]
    print(f"{os.cpu_count()} cores, load before the start {load:.1f}", flush=True)
    with tempfile.TemporaryDirectory() as folder:
        for error in ERRORS:
            compare_within_error(error, pairs, Path(folder))
        print_axial_alone()
        compare_on_one_mesh(max(1, pairs // 2), Path(folder))


if __name__ == "__main__":
    if sys.argv[1:2] and sys.argv[1] in ROLES:
        print(json.dumps(ROLES[sys.argv[1]](*sys.argv[2:])))
    elif sys.argv[1:2] == ["reference"]:
        print_reference()
    else:
        main(*(int(text) for text in sys.argv[1:2]))
