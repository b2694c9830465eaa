"""A worker process: reads designs as JSON lines, answers with their responses as JSON lines.

Started by `regression.workers`; it ends when its input ends, so no worker outlives its coordinator.
"""

import json
import math
import os
import signal
import sys
import time
from typing import Any, TextIO

from fem.analysis import throw_responses
from fem.material import Material
from geometry.mesher import mesh_here
from geometry.throw import CrankThrow


def evaluate_design(inputs: dict[str, Any]) -> dict[str, float]:
    """Compute the responses of one design.

    Parameters
    ----------
    inputs : dict
        ``throw`` and ``material`` as field: SI value, ``accuracy``.

    Returns
    -------
    dict
        As `fem.analysis.throw_responses` gives them.
    """
    throw, material = CrankThrow(**inputs["throw"]), Material(**inputs["material"])
    # This process is expendable: gmsh needs none of its own.
    return throw_responses(throw, material, inputs["accuracy"], mesher=mesh_here)


def _numbers_only(responses: dict[str, float]) -> dict[str, float]:
    for name, value in responses.items():
        if not math.isfinite(value):
            raise ArithmeticError(f"{name} came out as {value}")
    return responses


def serve(requests: TextIO, answers: TextIO) -> None:
    """Answer requests until there are no more."""
    for line in requests:
        request = json.loads(line)
        start = time.perf_counter()
        answer: dict[str, Any] = {"key": request["key"]}
        try:
            answer["responses"] = _numbers_only(evaluate_design(request["inputs"]))
        except Exception as error:  # the design fails, with its reason; the worker goes on
            answer["reason"] = f"{type(error).__name__}: {error}"
        answer["seconds"] = time.perf_counter() - start
        print(json.dumps(answer), file=answers, flush=True)


def main() -> None:
    """Serve on standard input and output, whatever libraries may print."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # the coordinator decides what an interrupt means
    answers = os.fdopen(os.dup(1), "w")
    os.dup2(2, 1)
    serve(sys.stdin, answers)


if __name__ == "__main__":
    main()
