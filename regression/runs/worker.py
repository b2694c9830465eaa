"""The task of a worker process: to compute the responses of designs.

`regression.runs.workers` starts it, as a child that ends with its coordinator.
"""

import math
import time
from typing import Any

from crankbase.errors import NotEnoughMemoryError
from fem.material import Material
from fem.responses import ThrowResponses, evaluate_throw
from geometry.mesher import mesh_here
from geometry.throw import CrankThrow

# Numbers of Pardiso's errors: no memory, within or for files; files that cannot be opened or written.
PARDISO_MACHINE = (-2, -9, -10, -11)


def evaluate_design(inputs: dict[str, Any]) -> ThrowResponses:
    """Compute the responses of a design: fields of throw and material [SI], accuracy, stresses."""
    return evaluate_throw(
        CrankThrow(**inputs["throw"]),
        Material(**inputs["material"]),
        inputs["accuracy"],
        inputs["stresses"],
        mesher=mesh_here,  # this process is expendable: gmsh needs none of its own
    )


def _numbers_only(numbers: dict[str, float], what: str = "") -> dict[str, float]:
    for name, value in numbers.items():
        if not math.isfinite(value):
            raise ArithmeticError(f"{what}{name} came out as {value}")
    return numbers


def _of_the_machine(error: BaseException | None) -> bool:
    """Whether an error is due to the machine (no memory, a full disk), not to the design."""
    while error is not None:
        # Without memory a library cannot be loaded either.
        if isinstance(error, MemoryError | OSError | ImportError | NotEnoughMemoryError):
            return True
        # Pardiso's own kind of error, known by its module: without Pardiso there is none.
        if type(error).__module__.startswith("pypardiso") and (
            getattr(error, "value", None) in PARDISO_MACHINE
        ):
            return True
        error = error.__cause__
    return False


def answer(request: dict[str, Any]) -> dict[str, Any]:
    """Handle the request for a design.

    The result has ``responses``, or the ``reason`` why the design has none, or ``lost``: the reason why the
    machine could not compute it, such as a full disk.
    """
    start = time.perf_counter()
    made: dict[str, Any]
    try:
        evaluated = evaluate_design(request["inputs"])
        made = {
            "responses": _numbers_only(evaluated.values),
            "errors": _numbers_only(evaluated.errors, "the error of "),
            "unknowns": evaluated.unknowns,
        }
    except Exception as error:  # the design fails, with its reason; the worker goes on
        kind = "lost" if _of_the_machine(error) else "reason"
        made = {kind: f"{type(error).__name__}: {error}"}
    return {"key": request["key"], **made, "seconds": time.perf_counter() - start}
