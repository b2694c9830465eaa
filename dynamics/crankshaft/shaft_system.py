"""The linear system of a whole crankshaft: its lower modes, and the static effect of the others."""

from dataclasses import dataclass, field

import numpy as np

from crankbase.checks.arrays import FloatArray, positive_number
from crankbase.checks.choices import check_choice
from crankbase.summaries import summarized
from dynamics.crankshaft.assembly import AssembledShaft
from dynamics.crankshaft.shaft_modes import ShaftModes, crankshaft_modes
from dynamics.crankshaft.shaft_throw import RZ, UZ
from dynamics.response.linear_system import LinearSystem, natural_modes

# Corrections of which the others compose all but this share are left out.
INDEPENDENT = 1e-10


@summarized("modes.frequencies [Hz]", "kept", "highest_frequency [Hz]")
@dataclass(frozen=True, eq=False)
class CrankshaftSystem:
    """A whole crankshaft, prepared for forced vibration.

    Attributes
    ----------
    shaft : AssembledShaft
    modes : ShaftModes
        Of all unknowns, before modes are left out.
    system : LinearSystem
        Its points are the sections (six motions each), the pins (three each, along the tangential and the
        radial force and along the shaft), and damper ring and driven machine, as in `names`.
    kept : int
        Elastic modes kept.
    corrections : int
        Static shapes that replace the modes left out.
    highest_frequency : float or None
        Up to which modes were kept [Hz]; None for all.
    momenta : (n + 1, q) array
        `AssembledShaft.momenta` per unknown of the system.
    """

    shaft: AssembledShaft
    modes: ShaftModes
    system: LinearSystem
    kept: int
    corrections: int
    highest_frequency: float | None
    momenta: FloatArray = field(repr=False)

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the points, row by row."""
        return self.shaft.names

    def point(self, name: str) -> int:
        """Return the row of a point such as "main bearing 1 uz" or "pin 1 radial".

        Raises
        ------
        InputError
            If there is none of that name.
        """
        check_choice("point", name, self.names, "these points of the shaft have names")
        return self.names.index(name)


def crankshaft_system(
    shaft: AssembledShaft, highest_frequency: float | None = None
) -> CrankshaftSystem:
    """Build the linear system of a crankshaft from its lower modes.

    Parameters
    ----------
    shaft : AssembledShaft
    highest_frequency : float, optional
        Modes up to this are kept [Hz]; all by default.

    Returns
    -------
    CrankshaftSystem

    Raises
    ------
    InputError
        If the frequency is not above zero.

    Notes
    -----
    The modes left out act like springs. Their static response to a unit force at each point where
    forces act (pins, axial forces and torques at both ends, dashpots) is kept as one more shape. So
    the response to constant forces there stays exact at every point of the shaft, and in vibration
    the error is proportional to the fourth power of frequency over that of the lowest mode left out.
    """
    modes = crankshaft_modes(shaft)
    rigid = modes.rigid
    if highest_frequency is None:
        cut = len(modes.frequencies)
    else:
        positive_number("highest_frequency", highest_frequency, "Hz", "modes are kept up to it")
        cut = max(rigid, int(np.count_nonzero(modes.frequencies <= highest_frequency)))
    corrections = _corrections(shaft, modes, cut)
    elastic = np.hstack((modes.shapes[:, rigid:cut], corrections))
    basis = np.hstack((shaft.rigid, elastic))
    mass, stiffness = (basis.T @ matrix @ basis for matrix in (shaft.mass, shaft.stiffness))
    natural, shapes = natural_modes(mass, stiffness, np.eye(len(mass))[:, :rigid])
    # Amplitudes of the modes are the unknowns: then no digits are lost between stiff and soft ones.
    basis = basis @ shapes
    unit = np.eye(len(natural))
    return CrankshaftSystem(
        shaft=shaft,
        modes=modes,
        system=LinearSystem(
            mass=unit,
            stiffness=np.diag(natural**2),
            damping=basis.T @ shaft.damping @ basis,
            loss=basis.T @ shaft.loss @ basis,
            rigid=unit[:, :rigid],
            expand=shaft.expand @ basis,
            natural=natural,
            shapes=unit,
        ),
        kept=cut - rigid,
        corrections=corrections.shape[1],
        highest_frequency=highest_frequency,
        momenta=shaft.momenta @ basis,
    )


def _corrections(shaft: AssembledShaft, modes: ShaftModes, cut: int) -> FloatArray:
    """Static responses (u, c) of the modes left out, of unit mass and orthogonal to each other."""
    left_out = modes.shapes[:, cut:]
    if not left_out.shape[1]:
        return left_out
    last = 6 * (shaft.section_count - 1)
    ends = shaft.sections[[UZ, RZ, last + UZ, last + RZ]]
    loads = np.vstack((shaft.pins, ends, shaft.dashpots, shaft.added))
    # In the modes left out: amplitudes (modes, loads), each load scaled to an answer of unit mass.
    answers = (left_out.T @ loads.T) / modes.angular_frequencies[cut:, np.newaxis] ** 2
    sizes = np.linalg.norm(answers, axis=0)
    answers = answers[:, sizes > 0.0] / sizes[sizes > 0.0]
    directions, singular, _ = np.linalg.svd(answers, full_matrices=False)
    return np.asarray(left_out @ directions[:, singular > INDEPENDENT * singular[0]])
