"""Stresses at the fillets in a run, computed coarsely."""

from crankbase.errors import InputError, MeshError
from fem import fillet_stress
from fem.fillet_peaks import FilletStresses
from fem.material import Material
from fem.solver import SolveError
from geometry.throw import CrankThrow

# Of the largest stresses: enough to compare fillets and to see which is the weakest.
ACCURACY = 0.1


def stresses_or_reason(
    throw: CrankThrow, material: Material
) -> tuple[FilletStresses | None, str | None]:
    """Compute the stresses at a throw's fillets; a throw for which they cannot be had loses nothing else.

    Parameters
    ----------
    throw : CrankThrow
    material : Material

    Returns
    -------
    FilletStresses or None
    str or None
        Why there are none.
    """
    try:
        return fillet_stress.fillet_stresses(throw, material, ACCURACY), None
    except (InputError, MeshError, SolveError) as error:
        return None, str(error)
