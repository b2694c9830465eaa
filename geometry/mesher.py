"""Mesh throws in a separate process, so that a crash of the mesher is contained."""

from collections.abc import Callable
from typing import Any

from crankbase.array_checks import positive_number
from crankbase.calls import ProcessLostError
from crankbase.choices import check_kind
from geometry.any_throw import Throw
from geometry.gmsh_session import IsolatedProcess, shared_process
from geometry.mesh import (
    MESHING_STRATEGIES,
    OnRemark,
    ThrowMesh,
    all_failed,
    checked_part,
    mesh_throw,
)
from geometry.sizes import SizeMap, predict_unknowns
from geometry.throw import CrankThrow

# Makes the mesh of a throw: size factor, part, and element sizes instead of the planned ones.
Mesher = Callable[[Throw, float, str, SizeMap | None], ThrowMesh]
# Seconds that one way of meshing may take, and more for each unknown; an ordinary quarter takes 0.2 s.
TIME_LIMIT = 60.0
SECONDS_PER_UNKNOWN = 2e-4


def mesh_isolated(
    throw: Throw,
    size_factor: float = 1.0,
    part: str = "auto",
    sizes: SizeMap | None = None,
    *,
    process: IsolatedProcess | None = None,
    time_limit: float = TIME_LIMIT,
) -> ThrowMesh:
    """Mesh a throw in a separate process.

    If a strategy ends the process or takes too long, a new one continues with the next strategy.

    Parameters
    ----------
    throw, size_factor, part, sizes
        As for `mesh_throw`, which describes the result and the errors.
    process : IsolatedProcess, optional
        Process for meshing; by default the one shared in this process.
    time_limit : float
        Time limit of one strategy [s]; larger for large meshes.

    Raises
    ------
    MeshError
        Also if gmsh crashes, or takes too long, with every strategy.
    """
    check_kind("throw", throw, Throw, "a CrankThrow, or what import_throw returns")
    process = shared_process() if process is None else process
    size_factor = positive_number("size_factor", size_factor, "", "it scales the elements")
    time_limit = positive_number("time_limit", time_limit, "s", "meshing takes time")
    limit = time_limit + SECONDS_PER_UNKNOWN * expected_unknowns(throw, size_factor, sizes)
    attempts: tuple[str, ...] = ()

    def note(made: tuple[str, ...]) -> None:
        nonlocal attempts
        attempts = made

    while len(attempts) < len(MESHING_STRATEGIES):
        try:
            mesh: ThrowMesh = process.call(
                *mesh_call(throw, size_factor, part, sizes, attempts),
                time_limit=limit,
                on_remark=note,
            )
        except ProcessLostError as error:
            attempts = (*attempts, f"{MESHING_STRATEGIES[len(attempts)].what}: {error}")
        else:
            return mesh
    raise all_failed(attempts)


def mesh_call(
    throw: Throw,
    size_factor: float,
    part: str = "auto",
    sizes: SizeMap | None = None,
    attempts: tuple[str, ...] = (),
) -> tuple[Any, ...]:
    """Function by name, and arguments, with which another process meshes a throw.

    It gets only the parts of a throw of dimensions, so that it need not load what reads these.

    Raises
    ------
    InputError
        If the throw lacks that symmetry.
    """
    part = checked_part(throw, part)
    if isinstance(throw, CrankThrow):
        return "geometry.mesh:mesh_parts", throw.parts, size_factor, part, sizes, attempts
    return "geometry.mesher:mesh_here", throw, size_factor, part, sizes, attempts


def mesh_here(
    throw: Throw,
    size_factor: float = 1.0,
    part: str = "auto",
    sizes: SizeMap | None = None,
    attempts: tuple[str, ...] = (),
    on_remark: OnRemark | None = None,
) -> ThrowMesh:
    """Mesh any throw in this process; parameters, results and errors as for `mesh_throw`."""
    if isinstance(throw, CrankThrow):
        return mesh_throw(throw, size_factor, part, sizes, attempts, on_remark)
    return throw.meshed(size_factor, part, sizes, attempts, on_remark)


def expected_unknowns(throw: Throw, size_factor: float, sizes: SizeMap | None = None) -> int:
    """Predict the number of unknowns of a throw's analysis with a size factor."""
    if sizes is not None:
        return sizes.expected_unknowns(size_factor)
    if isinstance(throw, CrankThrow):
        return predict_unknowns(throw.parts, size_factor, throw.symmetry)
    return throw.expected_unknowns(size_factor)
