"""What moves in each kind of vibration, and the units in which its amplitudes are read."""

from typing import Literal, NamedTuple


class Motion(NamedTuple):
    """Motion of a node in one kind of vibration.

    Attributes
    ----------
    quantity : str
        What diagrams call it.
    si : str
        Its unit in records.
    printed : str
        Its unit among those of `crankfem.output_units`.
    unit : str
        The same as diagrams and reports write it.
    size : float
        Of that unit, in SI.
    """

    quantity: Literal["displacement", "twist"]
    si: str
    printed: str
    unit: str
    size: float


MOTION = {
    "axial": Motion("displacement", "m", "um", "µm", 1e-6),
    "torsional": Motion("twist", "rad", "mrad", "mrad", 1e-3),
}
