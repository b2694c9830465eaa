"""The first mesh of an analysis, which can be begun while what solves is loaded."""

from geometry.any_throw import Throw
from geometry.gmsh_session import shared_process
from geometry.mesher import expected_unknowns, mesh_call
from geometry.throw import CrankThrow

# Size factor of the first mesh, and from which accuracy on it is how much coarser: answers are then within
# 1 % of the finest ones (docs/accuracy.md).
FIRST_FILLETED = 2.0
FIRST_SHARP = 2.2
LITTLE_ACCURACY, COARSER = 0.04, 1.5
# With oil holes it is planned for this times the squared inverse of the wished accuracy, as far as this
# factor goes: holes are small and many elements stand round them, though they hardly change compliances.
# So is the first refined mesh, which has some 1.4 times the unknowns that are planned.
FIRST_DRILLED, COARSEST_DRILLED, REFINED_DRILLED = 36.0, 12.0, 33.0
MOST_UNKNOWNS = 450_000


def first_factor(throw: Throw, accuracy: float) -> float:
    """Size factor of the first mesh for an accuracy of the axial compliance."""
    factor = FIRST_FILLETED if throw.filleted else FIRST_SHARP
    factor *= COARSER if accuracy >= LITTLE_ACCURACY else 1.0
    most = most_planned(throw, accuracy, FIRST_DRILLED)
    while factor < COARSEST_DRILLED and expected_unknowns(throw, factor) > most:
        factor *= 1.1
    while expected_unknowns(throw, factor) > MOST_UNKNOWNS:
        factor *= 1.2
    return factor


def most_planned(throw: Throw, accuracy: float, planned: float) -> float:
    """Most unknowns that the first mesh, or the first refined one, is planned for."""
    if isinstance(throw, CrankThrow) and throw.oil_holes:
        return min(planned / accuracy**2, MOST_UNKNOWNS)
    return MOST_UNKNOWNS


def begin_mesh(throw: Throw, accuracy: float) -> None:
    """Let the mesher begin the first mesh of an analysis of this throw to this accuracy."""
    shared_process().begin(*mesh_call(throw, first_factor(throw, accuracy)), remarks=True)
