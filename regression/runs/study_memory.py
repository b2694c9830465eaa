"""The memory of a study's workers, predicted before they start."""

from collections.abc import Mapping, Sequence
from typing import Any

from crankbase.calls import GIGABYTE
from crankbase.memory import check_memory, free_memory
from fem.accuracy import predicted_unknowns
from fem.memory import solving_memory
from geometry.mesh_checks import MESHING_MEMORY
from geometry.mesher import expected_unknowns
from geometry.throw import CrankThrow

# Designs that are looked at, spread over all.
LOOKED_AT = 30
# The finest mesh for stresses at fillets has up to so many times the unknowns of an ordinary one.
STRESS_GROWTH = 4.0
# Of the mesher, which is loaded in the same process [byte].
MESHER = 4e7


def worker_memory(designs: Sequence[Mapping[str, Any]]) -> float:
    """Predict the resident memory of a worker that computes designs, by their inputs [byte]."""
    step = max(1, len(designs) // LOOKED_AT)
    most = 0.0
    for inputs in designs[::step]:
        throw = CrankThrow(**inputs["throw"])
        unknowns = predicted_unknowns(throw, inputs["accuracy"])
        most = max(most, solving_memory(throw, unknowns) + MESHING_MEMORY * unknowns)
        if inputs["stresses"]:
            unknowns = STRESS_GROWTH * expected_unknowns(throw, 1.0)
            taken = solving_memory(throw, unknowns, stresses=True) + MESHING_MEMORY * unknowns
            most = max(most, taken)
    return most + MESHER


def check_study_memory(designs: Sequence[Mapping[str, Any]], workers: int) -> None:
    """Refuse workers that would need more memory together than is free.

    Raises
    ------
    NotEnoughMemoryError
    """
    if not designs:
        return
    working = min(workers, len(designs))
    each = worker_memory(designs)
    fit = int(free_memory() // each)
    check_memory(
        working * each,
        f"workers: given {workers}, of which {working} take about {each / GIGABYTE:.2g} GB each, together",
        f"ask for at most {fit}" if fit else "ask for a coarser accuracy, or free memory",
    )
