"""A system with viscous damping in place of loss factors, which are undefined over time."""

from dataclasses import dataclass, replace
from typing import Literal, TypedDict, get_args

import numpy as np
from numpy.typing import ArrayLike

from crankbase.checks.arrays import positive_number
from crankbase.checks.choices import check_choice
from crankbase.errors import InputError
from crankbase.summaries import summarized
from dynamics.chains.chain import Chain
from dynamics.response.forced import chain_and_system
from dynamics.response.linear_system import LinearSystem

LossAs = Literal["viscous", "modal"]


class ViscousDamping(TypedDict, total=False):
    """Damping arguments of `viscous_system`, which see."""

    loss_as: LossAs
    loss_frequency: float | None
    magnifier: float | None
    modal_damping: ArrayLike | None


@summarized("system.natural", "note")
@dataclass(frozen=True, eq=False)
class ViscousSystem:
    """A linear system that can be integrated over time.

    Parameters
    ----------
    system : LinearSystem
        Without hysteretic damping.
    chain : Chain or None
        Its origin.
    note : str
        How loss factors were replaced; empty if there are none.
    """

    system: LinearSystem
    chain: Chain | None
    note: str


def viscous_system(
    chain_or_system: Chain | LinearSystem,
    *,
    loss_as: LossAs = "viscous",
    loss_frequency: float | None = None,
    magnifier: float | None = None,
    modal_damping: ArrayLike | None = None,
) -> ViscousSystem:
    """Return the system with loss factors replaced by viscous damping, and modal damping added.

    Parameters
    ----------
    chain_or_system : Chain or LinearSystem
    loss_as : {"viscous", "modal"}
        "viscous": each element of loss factor eta and stiffness k gets a damper of
        eta k / w, exact at one angular frequency w. "modal": each elastic mode gets half of its own
        loss factor as share of critical damping, exact at the frequency of each mode, without the
        coupling of modes by damping.
    loss_frequency : float, optional
        w for "viscous" [rad/s]; the lowest elastic mode's by default.
    magnifier : float, optional
        Adds to each elastic mode the damping of this magnifier, 1 / (2 magnifier) of critical.
    modal_damping : float or array_like, optional
        Adds to each elastic mode this share of critical damping.

    Returns
    -------
    ViscousSystem

    Raises
    ------
    InputError
        If a number is out of range, the way is unknown, both magnifier and modal damping are given,
        or a loss frequency is given that is not used.

    Notes
    -----
    Under harmonic motion of angular frequency W a loss factor causes the force i eta k x, a damper
    i W c x: with c = eta k / w the energy lost in a cycle is exact at W = w and wrong by W / w
    elsewhere. The mode of natural frequency w_r and shape x_r has the loss factor
    x_r' H x_r / (w_r^2 x_r' M x_r).
    """
    chain, system = chain_and_system(chain_or_system)
    why = "these are the ways to put viscous damping in the place of loss factors"
    check_choice("loss_as", loss_as, get_args(LossAs), why)
    frequency = None
    if loss_frequency is not None:
        frequency = positive_number(
            "loss_frequency", loss_frequency, "rad/s", "damping is right at one frequency"
        )
        if loss_as == "modal":
            raise InputError(
                f"loss_frequency: given {frequency:g} rad/s; allowed is none with loss_as='modal', "
                "because there each mode takes its own frequency."
            )
    replaced, note = _without_loss(system, loss_as, frequency)
    return ViscousSystem(replaced.with_added_damping(magnifier, modal_damping), chain, note)


def _without_loss(
    system: LinearSystem, loss_as: LossAs, frequency: float | None
) -> tuple[LinearSystem, str]:
    if not np.any(system.loss):
        return system, ""
    count = system.rigid.shape[1]
    plain = replace(system, loss=np.zeros_like(system.loss))
    natural, shapes = system.natural[count:], system.shapes[:, count:]
    if loss_as == "modal":
        losses = np.sum(shapes * (system.loss @ shapes), axis=0) / natural**2
        note = "Loss factors as modal damping, half the loss factor of each mode."
        return plain.with_modal_damping(0.5 * losses), note
    right_at = float(natural[0]) if frequency is None else frequency
    which = ", that of the lowest elastic mode" if frequency is None else ""
    note = (
        f"Loss factors as viscous damping of the elements, equal at {right_at / (2.0 * np.pi):.6g} Hz"
        f"{which}."
    )
    return replace(plain, damping=plain.damping + system.loss / right_at), note
