"""Memory for the solution of a throw, predicted from the number of unknowns before meshing."""

from crankbase.memory import check_memory
from geometry.mesher import Throw
from geometry.throw import CrankThrow

# Bytes of a process that has loaded what solving needs, and for each unknown of a quarter or half with all
# solutions that a superelement needs. Fitted to resident memory of 6,000 to 180,000 unknowns, which it meets
# within 30 % (docs/developers/faults.md).
LIBRARIES, PER_UNKNOWN = 1.9e8, 6.9e3
# Of a whole throw all solutions are held at once; under the unit loads for stresses there are fewer.
WHOLE, FOR_STRESSES = 1.5, 0.6


def solving_memory(throw: Throw, unknowns: float, *, stresses: bool = False) -> float:
    """Predict the resident memory of a process that solves a throw [byte].

    Parameters
    ----------
    throw : CrankThrow or ImportedThrow
    unknowns : float
        Of the meshed part.
    stresses : bool
        Whether for the stresses at its fillets alone, or for its superelement.
    """
    each = PER_UNKNOWN * (FOR_STRESSES if stresses else 1.0)
    if not isinstance(throw, CrankThrow) or throw.symmetry == "full":
        each *= WHOLE
    return LIBRARIES + each * unknowns


def check_solving_memory(
    throw: Throw, unknowns: float, accuracy: float, *, stresses: bool = False
) -> None:
    """Refuse a mesh whose solution would need more memory than is free.

    Parameters
    ----------
    throw, unknowns, stresses
        As for `solving_memory`.
    accuracy : float
        Requested accuracy.

    Raises
    ------
    NotEnoughMemoryError
    """
    rounded = float(f"{unknowns:.2g}")
    check_memory(
        solving_memory(throw, unknowns, stresses=stresses) - LIBRARIES,  # which are loaded by now
        f"accuracy: given {accuracy:g}, whose next mesh of about {rounded:,.0f} unknowns takes",
        "ask for a larger accuracy, or free memory",
    )
