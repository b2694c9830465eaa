"""A worker process: reads designs as JSON lines, answers with their responses as JSON lines.

Started by `regression.workers`; it ends when its input ends, so no worker outlives its coordinator.
"""

import json
import os
import signal
import sys
import time
from typing import Any, TextIO

from fem.analysis import AXIAL, TORSIONAL, analyze_throw
from fem.material import Material
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
        Compliances for both supports [m/N, rad/(N m)], influence coefficients [m/N], mass [kg],
        error estimate, unknowns.
    """
    analysis = analyze_throw(
        CrankThrow(**inputs["throw"]),
        Material(**inputs["material"]),
        inputs["accuracy"],
        classes=(AXIAL, TORSIONAL),
    )
    responses: dict[str, float] = {}
    for support in ("pinned", "guided"):
        answer = analysis.supported(support)
        responses[f"axial_compliance_{support}"] = answer.axial
        responses[f"torsional_compliance_{support}"] = answer.torsional
        responses[f"influence_coefficient_{support}"] = answer.influence
    responses["mass"] = analysis.mass
    responses["error_estimate"] = analysis.error_estimate
    responses["unknowns"] = float(analysis.mesh.unknowns)
    return responses


def serve(requests: TextIO, answers: TextIO) -> None:
    """Answer requests until there are no more."""
    for line in requests:
        request = json.loads(line)
        start = time.perf_counter()
        answer: dict[str, Any] = {"key": request["key"]}
        try:
            answer["responses"] = evaluate_design(request["inputs"])
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
