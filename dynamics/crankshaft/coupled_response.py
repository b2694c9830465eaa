"""Coupled forced vibration of a whole crankshaft, and what tangential and radial forces do apart."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from dynamics.checks import ComplexArray, FloatArray
from dynamics.crankshaft.pin_excitation import PinForces, shaft_excitation
from dynamics.crankshaft.shaft_system import CrankshaftSystem
from dynamics.response.forced import ForcedResponse, forced_response
from dynamics.response.linear_system import DEFAULT_MAGNIFIER
from dynamics.response.synthesis import synthesis
from geometry.errors import InputError


@dataclass(frozen=True, eq=False)
class CoupledResponse:
    """Steady vibration of a whole crankshaft by orders, with both kinds of force kept apart.

    Attributes
    ----------
    crankshaft : CrankshaftSystem
    tangential, radial : ForcedResponse
        Under tangential forces alone and under radial forces alone; the motion under both is the sum.
    """

    crankshaft: CrankshaftSystem
    tangential: ForcedResponse
    radial: ForcedResponse

    @property
    def orders(self) -> FloatArray:
        """(K,), in cycles per revolution."""
        return self.tangential.orders

    @property
    def speeds(self) -> FloatArray:
        """(S,) [rad/s]."""
        return self.tangential.speeds

    @property
    def unbounded(self) -> NDArray[np.bool_]:
        """Where either answer has no bounds, (K, S)."""
        return self.tangential.unbounded | self.radial.unbounded

    def motion(self, point: str) -> ComplexArray:
        """Return the motion (K, S) of a point such as "section 0 uz" under both kinds of force.

        Raises
        ------
        ValueError
            If there is no such point.
        """
        row = self.crankshaft.point(point)
        return np.asarray(self.tangential.motion[:, :, row] + self.radial.motion[:, :, row])

    def split(self, point: str) -> "SplitMotion":
        """Return what both kinds of force do at a point, order by order and summed over a cycle.

        The motion of the shaft as a rigid body, which strains nothing, is left out.

        Raises
        ------
        ValueError
            If there is no such point.
        """
        row = self.crankshaft.point(point)
        rigid = self.crankshaft.system.rigid.shape[1]
        # Amplitudes of modes are the unknowns of this system, rigid motions first.
        mode_motion = self.crankshaft.system.expand[row, rigid:]
        apart = [
            each.unknowns[:, :, rigid:] @ mode_motion for each in (self.tangential, self.radial)
        ]
        found = []
        for motion in (apart[0], apart[1], apart[0] + apart[1]):
            amplitude = np.where(self.unbounded, np.inf, np.abs(motion))
            summed = synthesis(self.orders, self.speeds, motion, self.unbounded).amplitude
            found.append((amplitude, summed))
        (by_t, sum_t), (by_z, sum_z), (by_both, sum_both) = found
        return SplitMotion(point, by_t, by_z, by_both, sum_t, sum_z, sum_both)


@dataclass(frozen=True, eq=False)
class SplitMotion:
    """Motion of a point [m or rad], by tangential forces, by radial forces, by both.

    Attributes
    ----------
    point : str
    tangential, radial, both : (K, S) array
        Amplitude by order and speed; inf where unbounded.
    tangential_sum, radial_sum, both_sum : (S,) array
        Half of the range that the sum of all orders covers over the working cycle; inf where one is
        unbounded.
    """

    point: str
    tangential: FloatArray
    radial: FloatArray
    both: FloatArray
    tangential_sum: FloatArray
    radial_sum: FloatArray
    both_sum: FloatArray


def coupled_response(
    crankshaft: CrankshaftSystem,
    forces: PinForces,
    *,
    pins: Sequence[int] | None = None,
    magnifier: float | None = DEFAULT_MAGNIFIER,
    modal_damping: ArrayLike | None = None,
) -> CoupledResponse:
    """Find the coupled vibration of a crankshaft under the forces of its cylinders.

    Parameters
    ----------
    crankshaft : CrankshaftSystem
        With the damping of its bearings, dampers and material.
    forces : CylinderForces
        By order, speed and cylinder.
    pins : sequence of int, optional
        Pin of each cylinder, as for `shaft_excitation`.
    magnifier : float or None
        Magnifier of every elastic mode, beside the damping that the system has; by default the measured
        one of `DEFAULT_MAGNIFIER`. None adds nothing.
    modal_damping : float or array_like, optional
        In its place, share of critical damping of every elastic mode.

    Returns
    -------
    CoupledResponse

    Raises
    ------
    InputError
        If pins or damping do not fit.
    """
    if modal_damping is not None:
        magnifier = None
    if not isinstance(crankshaft, CrankshaftSystem):
        raise InputError(
            f"crankshaft: given {crankshaft!r}; allowed is a CrankshaftSystem, as crankshaft_system makes."
        )
    system = crankshaft.system
    if magnifier is not None:
        system = system.with_magnifier(magnifier)
    if modal_damping is not None:
        system = system.with_modal_damping(modal_damping)
    parts = [
        shaft_excitation(crankshaft, forces, pins=pins, tangential=one, radial=not one)
        for one in (True, False)
    ]
    answers = [forced_response(system, part) for part in parts]
    return CoupledResponse(crankshaft, *answers)
