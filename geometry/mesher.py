"""Mesh throws in a process of its own, so that no throw can take this one down."""

import atexit
import os
from functools import cache

from geometry.errors import MeshError
from geometry.isolated import IsolatedProcess, ProcessLostError
from geometry.mesh import LADDER, ThrowMesh
from geometry.sizes import predict_unknowns
from geometry.throw import CrankThrow

# Seconds that one way of meshing may take, and more for each unknown; an ordinary quarter takes 0.2 s.
TIME_LIMIT = 60.0
SECONDS_PER_UNKNOWN = 2e-4


def mesh_isolated(
    throw: CrankThrow,
    size_factor: float = 1.0,
    part: str = "auto",
    *,
    process: IsolatedProcess | None = None,
    time_limit: float = TIME_LIMIT,
) -> ThrowMesh:
    """Mesh a throw in a process of its own.

    When a way of meshing ends the process or takes too long, a fresh one goes on with the next way.

    Parameters
    ----------
    throw, size_factor, part
        As for `mesh_throw`, which says what is returned and raised.
    process : IsolatedProcess, optional
        Where to mesh; the one that this process shares by default.
    time_limit : float
        Seconds that one way of meshing may take; large meshes are given more.

    Raises
    ------
    MeshError
        Also if gmsh crashes, or takes too long, in every way of meshing.
    """
    process = shared_process() if process is None else process
    limit = time_limit + SECONDS_PER_UNKNOWN * predict_unknowns(
        throw.parts, size_factor, throw.symmetry
    )
    attempts: tuple[str, ...] = ()

    def note(made: tuple[str, ...]) -> None:
        nonlocal attempts
        attempts = made

    while len(attempts) < len(LADDER):
        try:
            mesh: ThrowMesh = process.call(
                "geometry.mesh:mesh_throw_from",
                throw,
                size_factor,
                part,
                attempts,
                time_limit=limit,
                on_remark=note,
            )
        except ProcessLostError as error:
            attempts = (*attempts, f"{LADDER[len(attempts)].what}: {error}")
        else:
            return mesh
    raise MeshError(
        f"{len(attempts)} ways of meshing the throw failed, the last one ({attempts[-1]})."
    )


@cache
def _process_of(_owner: int) -> IsolatedProcess:
    process = IsolatedProcess()
    atexit.register(process.close)
    return process


def shared_process() -> IsolatedProcess:
    """Return the process that all calls from this one share; a forked child gets one of its own."""
    return _process_of(os.getpid())
