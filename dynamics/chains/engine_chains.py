"""Build the axial and the torsional chain of an engine from the compliances of its throws."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from dynamics.chains.chain import Chain
from dynamics.checks import (
    FloatArray,
    node_index,
    nonnegative_number,
    positive_number,
    positive_vector,
    values_at_nodes,
)
from geometry.errors import InputError


@dataclass(frozen=True, eq=False)
class NamedChain:
    """A chain whose nodes have names.

    Parameters
    ----------
    chain : Chain
        Inertias and stiffnesses.
    nodes : tuple of str
        Names of the nodes, from the free end to the flywheel and beyond.
    kind : {"axial", "torsional"}
        Which motion the chain stands for, and so its units.
    """

    chain: Chain
    nodes: tuple[str, ...]
    kind: Literal["axial", "torsional"]


@dataclass(frozen=True)
class DrivenMachine:
    """What the engine drives: one inertia behind a coupling.

    Parameters
    ----------
    inertia : float
        Moment of inertia, referred to the crankshaft speed [kg m^2].
    coupling_stiffness : float
        Torsional stiffness between flywheel and machine [N m/rad].

    Raises
    ------
    InputError
        If a value is not a finite number above zero.
    """

    inertia: float
    coupling_stiffness: float

    def __post_init__(self) -> None:
        positive_number("driven.inertia", self.inertia, "kg m^2", "a machine has inertia")
        positive_number(
            "driven.coupling_stiffness",
            self.coupling_stiffness,
            "N m/rad",
            "without stiffness the machine is not coupled",
        )


def axial_chain(
    throw_compliances: ArrayLike,
    throw_masses: ArrayLike,
    flywheel_mass: float,
    thrust_node: int,
    thrust_stiffness: float,
    extra_masses: ArrayLike | Mapping[int, float] | None = None,
) -> NamedChain:
    """Build the axial chain of a crankshaft: masses at the middles of the main journals.

    Section 0 is the middle of the main journal at the free end, section n that at the flywheel;
    throw i joins sections i - 1 and i, and half of its mass goes to either.

    Parameters
    ----------
    throw_compliances : array_like of shape (n,)
        Axial compliance e_n of each throw as it stands in the shaft, between its neighbors [m/N].
    throw_masses : array_like of shape (n,)
        Mass of each throw from journal middle to journal middle [kg].
    flywheel_mass : float
        Mass of flywheel and flange [kg], at section n; 0 for none.
    thrust_node : int
        Section held by the thrust bearing, 0 to n.
    thrust_stiffness : float
        Axial stiffness of the thrust bearing to ground [N/m]; 0 leaves the shaft free.
    extra_masses : array_like of shape (n + 1,) or mapping of int to float, optional
        Further masses at the sections [kg], such as a damper or gear at section 0.

    Returns
    -------
    NamedChain
        n + 1 nodes [kg], n springs [N/m], and the thrust bearing to ground [N/m].

    Raises
    ------
    InputError
        If a compliance or throw mass is not above zero, another value is negative, or lengths or
        the thrust node do not fit.
    """
    compliances = _checked_compliances(throw_compliances, "m/N")
    masses = positive_vector("throw_masses", throw_masses, "kg", "every throw has mass")
    _check_one_per_throw("throw_masses", masses, compliances)
    count = compliances.size
    thrust = node_index("thrust_node", thrust_node, count + 1)
    bearing = nonnegative_number(
        "thrust_stiffness", thrust_stiffness, "N/m", "a bearing does not push the shaft away"
    )
    at_sections = values_at_nodes(
        "extra_masses", extra_masses, count + 1, "kg", "they add to those of the shaft"
    )
    at_sections[:-1] += masses / 2.0
    at_sections[1:] += masses / 2.0
    at_sections[-1] += nonnegative_number(
        "flywheel_mass", flywheel_mass, "kg", "it adds to the mass of the shaft"
    )
    names = [f"section {number}" for number in range(count + 1)]
    if flywheel_mass > 0.0:
        names[-1] += ", flywheel"
    if bearing > 0.0:
        names[thrust] += ", thrust bearing"
    chain = Chain(at_sections, 1.0 / compliances, {thrust: bearing})
    return NamedChain(chain, tuple(names), "axial")


def torsional_chain(
    throw_compliances: ArrayLike,
    throw_inertias: ArrayLike,
    flywheel_inertia: float,
    free_end_inertia: float = 0.0,
    driven: DrivenMachine | None = None,
) -> NamedChain:
    """Build the torsional chain of an engine: one inertia at each crank, and what stands around.

    Parameters
    ----------
    throw_compliances : array_like of shape (n,)
        Torsional compliance of each throw from journal middle to journal middle [rad/(N m)].
    throw_inertias : array_like of shape (n,)
        Moment of inertia of each throw with its share of rod and piston [kg m^2], as
        `throw_inertia` gives it.
    flywheel_inertia : float
        Moment of inertia of the flywheel [kg m^2].
    free_end_inertia : float
        Moment of inertia at the free end, such as a pulley or damper hub [kg m^2]; 0 for none.
    driven : DrivenMachine, optional
        The driven machine and its coupling.

    Returns
    -------
    NamedChain
        Free end if any, cylinders 1 to n, flywheel, driven machine if any [kg m^2, N m/rad].

    Raises
    ------
    InputError
        If a compliance or an inertia is not above zero, the inertia at the free end is negative,
        or the lengths differ.

    Notes
    -----
    The inertia of a throw sits at its crank, in the middle of its compliance: cylinders i and
    i + 1 are joined by half of either throw's compliance; free end and flywheel are joined by half
    of the throw next to them, the journal stubs beyond the last middles being counted as stiff.
    """
    compliances = _checked_compliances(throw_compliances, "rad/(N m)")
    inertias = positive_vector(
        "throw_inertias", throw_inertias, "kg m^2", "every throw has inertia"
    )
    _check_one_per_throw("throw_inertias", inertias, compliances)
    flywheel = positive_number(
        "flywheel_inertia", flywheel_inertia, "kg m^2", "the chain ends at the flywheel"
    )
    free_end = nonnegative_number(
        "free_end_inertia", free_end_inertia, "kg m^2", "it is that of a body, or none"
    )
    nodes = [f"cylinder {number}" for number in range(1, compliances.size + 1)] + ["flywheel"]
    chain_inertias = [*inertias.tolist(), flywheel]
    halves = compliances / 2.0
    joined = [*(halves[:-1] + halves[1:]).tolist(), float(halves[-1])]
    if free_end > 0.0:
        nodes.insert(0, "free end")
        chain_inertias.insert(0, free_end)
        joined.insert(0, float(halves[0]))
    stiffnesses = [1.0 / compliance for compliance in joined]
    if driven is not None:
        nodes.append("driven machine")
        chain_inertias.append(driven.inertia)
        stiffnesses.append(driven.coupling_stiffness)
    return NamedChain(Chain(chain_inertias, stiffnesses), tuple(nodes), "torsional")


def throw_inertia(
    solid_inertia_about_shaft: float,
    rod_rotating_mass: float,
    reciprocating_mass: float,
    crank_radius: float,
) -> float:
    """Return the constant moment of inertia that stands for a throw with its rod and piston.

    Parameters
    ----------
    solid_inertia_about_shaft : float
        Moment of inertia of the solid throw about the shaft axis [kg m^2].
    rod_rotating_mass : float
        Share of the connecting rod that turns with the crankpin [kg].
    reciprocating_mass : float
        Piston with pin, and the share of the rod that moves with it [kg].
    crank_radius : float
        R [m].

    Returns
    -------
    float
        I + m_rot R^2 + m_rec R^2 / 2 [kg m^2].

    Raises
    ------
    InputError
        If the inertia or the radius is not above zero, or a mass is negative.

    Notes
    -----
    The piston moves by R (sin a + (lambda / 2) sin 2a) per radian of crank angle, so that its
    inertia at the shaft varies over the revolution; half the reciprocating mass is the mean of
    that over the cycle to zeroth order in the crank ratio lambda (the next term is
    m_rec R^2 lambda^2 / 8). The variation itself, which excites secondary resonances in slow
    engines with heavy pistons, is left out.
    """
    solid = positive_number(
        "solid_inertia_about_shaft", solid_inertia_about_shaft, "kg m^2", "every throw has inertia"
    )
    why = "it adds to the inertia of the throw"
    rotating = nonnegative_number("rod_rotating_mass", rod_rotating_mass, "kg", why)
    reciprocating = nonnegative_number("reciprocating_mass", reciprocating_mass, "kg", why)
    R = positive_number("crank_radius", crank_radius, "m", "the stroke is twice as long")
    return solid + (rotating + reciprocating / 2.0) * R**2


def _checked_compliances(throw_compliances: ArrayLike, unit: str) -> FloatArray:
    compliances = positive_vector(
        "throw_compliances", throw_compliances, unit, "every throw yields under load"
    )
    if compliances.size == 0:
        raise InputError(
            "throw_compliances: given no values; allowed are one or more, because a crankshaft has "
            "a throw."
        )
    return compliances


def _check_one_per_throw(field: str, values: FloatArray, compliances: FloatArray) -> None:
    if np.size(values) != np.size(compliances):
        raise InputError(
            f"{field}: given {values.size} values for {compliances.size} compliances; allowed are "
            f"exactly {compliances.size}, because there is one for each throw."
        )
