"""Memory of throws' analyses, each in a fresh process, beside what is predicted before they are meshed.

Run by hand: python tests/campaigns/predicted_memory.py (some minutes). Prints unknowns and resident memory,
predicted and found, of engines' throws and of random ones; exit code 1 if memory is off by more than 30 %,
or unknowns are predicted 30 % too few or twice too many.
"""

import json
import resource
import subprocess
import sys

from random_throws import random_throw
from study_tools import environment, said

from crankfem.files.engine.engine_file import load_engine
from fem.analysis import analyze_throw, predicted_unknowns, solving_memory
from fem.fillet_stress import fillet_stresses
from geometry.any_throw import Throw

ALLOWED = 0.30
# Unknowns are predicted for throws whose errors fall slowly: others take fewer.
SPARE = 1.0
# What is computed, of which throw (an engine's, or a random one's seed), at which accuracy.
CASES = [
    ("superelement", "6chn25-34", 0.01),
    ("superelement", "6chn25-34", 0.001),
    ("superelement", "yamz-5340", 0.002),
    ("superelement", "2", 0.02),
    ("superelement", "2", 0.002),
    ("superelement", "6", 0.01),
    ("superelement", "13", 0.02),
    ("superelement", "13", 0.005),
    ("stresses", "6chn25-34", 0.05),
    ("stresses", "yamz-5340", 0.05),
    ("stresses", "yamz-5340", 0.02),
    ("stresses by UR M53", "6chn25-34", 0.05),
]


def throw_of(name: str) -> Throw:
    return random_throw(int(name)) if name.isdecimal() else load_engine(name).throw


def measure(task: str, name: str, accuracy: float) -> None:
    """Print the unknowns of the finest mesh and the largest resident memory of this process."""
    throw = throw_of(name)
    if task == "stresses":
        unknowns = fillet_stresses(throw, accuracy=accuracy).loaded.mesh.unknowns
    elif task == "stresses by UR M53":
        unknowns = fillet_stresses(throw, accuracy=accuracy, mesh="m53").loaded.mesh.unknowns
    else:
        unknowns = analyze_throw(throw, accuracy=accuracy).mesh.unknowns
    taken = 1024 * resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    print(json.dumps([unknowns, taken]))


def main() -> int:
    good = True
    for task, name, accuracy in CASES:
        line = [sys.executable, __file__, task, name, str(accuracy)]
        done = subprocess.run(line, env=environment(), capture_output=True, text=True, check=True)
        unknowns, taken = json.loads(done.stdout)
        throw, stresses = throw_of(name), task != "superelement"
        memory = solving_memory(throw, unknowns, stresses=stresses) / taken
        mesh = 1.0 if stresses else predicted_unknowns(throw, accuracy) / unknowns
        good &= said(
            f"{task}, throw {name} ({throw.symmetry}), {accuracy:g}: {unknowns:,} unknowns, "
            f"{taken / 1e6:.0f} MB; predicted: unknowns {100.0 * (mesh - 1.0):+.0f} %, "
            f"memory {100.0 * (memory - 1.0):+.0f} %",
            good=abs(memory - 1.0) < ALLOWED and -ALLOWED < mesh - 1.0 < SPARE,
        )
    return 0 if good else 1


if __name__ == "__main__":
    if sys.argv[1:]:
        measure(sys.argv[1], sys.argv[2], float(sys.argv[3]))
    else:
        raise SystemExit(main())
