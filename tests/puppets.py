"""Worker processes that do no finite elements."""

import os
import subprocess
import sys
from pathlib import Path

from regression.runs import workers as workers_module

# Goes before a puppet's own code: the requests as they come, and how to answer one.
PRELUDE = """
import os, pickle, sys, time
def requests():
    while True:
        try:
            _, (request,), _ = pickle.load(sys.stdin.buffer)
        except EOFError:
            return
        yield request
def answer(content):
    pickle.dump(("result", content), sys.stdout.buffer)
    sys.stdout.buffer.flush()
"""

# A worker that answers designs by power laws: that studies compute what they should is tested elsewhere.
STAND_IN = """
SIZES = {
    "axial_compliance_pinned": (1.3e-9, -1.0), "axial_compliance_guided": (0.26e-9, -0.5),
    "axial_compliance_opposite": (1.3e-9, -1.0), "axial_compliance_in_line": (0.26e-9, -0.5),
    "tilt_stiffness_ratio": (2.6, -0.2),
    "torsional_compliance_pinned": (4e-8, -0.1), "torsional_compliance_guided": (3.6e-8, -0.1),
    "influence_coefficient_pinned": (0.6e-9, -1.0), "influence_coefficient_guided": (0.1e-9, -0.5),
    "influence_coefficient_opposite": (0.6e-9, -1.0), "influence_coefficient_in_line": (0.1e-9, -0.5),
    "axial_reaction_pinned": (0.46, -0.1), "axial_reaction_guided": (0.38, -0.1),
    **{f"radial_end_moment_{end}": (0.13, 0.1) for end in ("left_guided", "right_guided", "in_line")},
    **{f"axial_end_moment_{end}": (0.24, -0.1) for end in ("left_guided", "right_guided", "in_line")},
    **{f"tangential_end_moment_{end}": (0.14, 0.1) for end in ("opposed_guided", "in_line")},
    **{f"tangential_end_moment_{end}": (0.13, 0.1) for end in ("alike_guided", "opposite")},
    "cross_tilt_stiffness_ratio": (1.9, 0.1), "mass": (100.0, 0.8), "fillet_stress_factor": (4.0, -0.3),
}
for request in requests():
    throw, stresses = request["inputs"]["throw"], request["inputs"]["stresses"]
    radius, width = throw["crank_radius"], throw["web_width"]
    thickness, pin = throw["web_thickness"], throw["pin_length"]
    shape = (width / (1.7 * radius)) ** -0.5 * (pin / (0.8 * radius)) ** 0.3
    responses = {
        name: size * shape * (thickness / (0.4 * radius)) ** exponent
        for name, (size, exponent) in SIZES.items()
        if stresses or name != "fillet_stress_factor"
    }
    errors = dict.fromkeys(responses, 0.004)
    found = {"key": request["key"], "responses": responses, "errors": errors, "seconds": 0.1}
    answer(found | {"unknowns": 9})
"""


def stand_in_worker():
    return puppet(STAND_IN)


def puppet(code):
    """Start a worker process that runs this code."""
    return subprocess.Popen(
        [sys.executable, "-S", "-c", PRELUDE + code], stdin=subprocess.PIPE, stdout=subprocess.PIPE
    )


def spawned(monkeypatch, program):
    """Make workers puppets that run a program, and return the list of those started."""
    started = []

    def spawn():
        started.append(puppet(program))
        return started[-1]

    monkeypatch.setattr(workers_module, "spawn_worker", spawn)
    return started


def marked(mark):
    """Return the living processes with a mark, this one left out."""
    found = []
    for folder in Path("/proc").iterdir():
        if not folder.name.isdigit() or int(folder.name) == os.getpid():
            continue
        try:
            environment = (folder / "environ").read_bytes().split(b"\0")
            state = (folder / "stat").read_text().rsplit(")", 1)[1].split()[0]
        except OSError:
            continue
        if mark in environment and state not in "ZX":
            found.append(int(folder.name))
    return found
