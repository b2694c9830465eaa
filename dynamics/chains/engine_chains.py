"""Build the axial and the torsional chain of an engine from the compliances of its throws."""

from collections.abc import Mapping, Sequence
from typing import Literal, get_args

import numpy as np
from numpy.typing import ArrayLike

from crankbase.array_checks import (
    Array,
    finite_array,
    nonnegative_number,
    nonnegative_vector,
    one_for_each,
    positive_number,
    positive_vector,
)
from crankbase.choices import check_choice, check_one_each, check_some, whole_number
from crankbase.errors import InputError
from crankbase.summaries import frozen
from dynamics.chains.chain import Chain
from dynamics.chains.chain_modes import Modes
from dynamics.chains.dampers import AxialDamper, TorsionalDamper, check_axial, check_torsional
from dynamics.chains.editing import join_chains, with_damper
from dynamics.chains.shaft_line import DrivenMachine
from dynamics.cycle import even_angles
from dynamics.engine.forces import parts_motion
from dynamics.engine.layout import EngineLayout
from dynamics.engine.rods import ConnectingRod, RodModel
from dynamics.indices import node_index, values_at_nodes
from dynamics.torque import checked_throws, throws_along_shaft

PASSIVE = "damping takes energy away"

Kind = Literal["axial", "torsional"]
FREE_END, FLYWHEEL = "free end", "flywheel"
# From this share of its strain energy in the crankshaft on, a mode is one of the crankshaft itself; with less
# it is one of the coupling, the damper's ring or the shaft line.
CRANKSHAFT_MODE = 0.5


@frozen("kind", "chain.inertia", "chain.stiffness", "throw_nodes", eq=False)
class EngineChain:
    """A chain of an engine, and which of its nodes are throws or sections of the crankshaft.

    Parameters
    ----------
    kind : {"axial", "torsional"}
        Kind of motion of the chain, which sets its units.
    throw_nodes : tuple of int
        Torsional: node of each throw, from the free end. Axial: empty.
    sections : tuple of int
        Axial: node of each section, the middles of the main journals, from 0 at the free end; throw
        i (from 0) joins sections i and i + 1 by element i. Torsional: empty.
    """

    chain: Chain
    kind: Kind
    throw_nodes: tuple[int, ...] = ()
    sections: tuple[int, ...] = ()

    @property
    def nodes(self) -> tuple[str, ...]:
        """Names of the nodes, from the free end to the flywheel and beyond."""
        return self.chain.names

    @property
    def throws(self) -> int:
        """Number of throws of the crankshaft."""
        return len(self.throw_nodes) if self.kind == "torsional" else len(self.sections) - 1

    @property
    def crank_elements(self) -> int:
        """Number of elements of the crankshaft, free end to flywheel: the first ones of the chain."""
        return self.throws if self.kind == "axial" else self.throw_nodes[-1] + 1

    def crankshaft_shares(self, modes: Modes) -> Array:
        """Return the share of each mode's strain energy in crankshaft and thrust bearing, (q,).

        The rest is in damper, coupling or shaft line. 1 for rigid motions.
        """
        elements = np.arange(len(modes.strain_shares))
        others = (elements >= self.crank_elements) & (elements < len(modes.connections))
        return np.asarray(1.0 - modes.strain_shares[others].sum(axis=0))

    def first_mode(self, modes: Modes) -> int | None:
        """Return the index of the lowest elastic mode of the crankshaft itself, rigid modes counted.

        Modes of a coupling, a damper's ring or a shaft line are skipped. None if there is no other.
        """
        shaft_modes = np.flatnonzero(
            self.crankshaft_shares(modes)[modes.rigid :] >= CRANKSHAFT_MODE
        )
        return modes.rigid + int(shaft_modes[0]) if shaft_modes.size else None


def axial_chain(
    throw_compliances: ArrayLike,
    throw_masses: ArrayLike,
    flywheel_mass: float,
    thrust_node: int,
    thrust_stiffness: float,
    extra_masses: ArrayLike | Mapping[int, float] | None = None,
    *,
    thrust_damping: float = 0.0,
    damping: ArrayLike = 0.0,
    loss_factor: ArrayLike = 0.0,
    section_damping: ArrayLike = 0.0,
    damper: AxialDamper | None = None,
    shaft_line: Chain | None = None,
) -> EngineChain:
    """Build the axial chain of a crankshaft: masses at the middles of the main journals.

    Section 0 is the middle of the main journal at the free end, section n that at the flywheel;
    throw i joins sections i - 1 and i, and contributes half of its mass to each.

    Parameters
    ----------
    throw_compliances : array_like of shape (n,)
        Axial compliance e_n of each throw in the shaft, between its neighbors [m/N].
    throw_masses : array_like of shape (n,)
        Mass of each throw from journal middle to journal middle [kg].
    flywheel_mass : float
        Mass of flywheel and flange [kg], at section n; 0 for none.
    thrust_node : int
        Index of the section held by the thrust bearing, 0 to n; it is main bearing `thrust_node` + 1.
    thrust_stiffness : float
        Axial stiffness of the thrust bearing to ground [N/m]; 0 leaves the shaft free.
    extra_masses : array_like of shape (n + 1,) or mapping of int to float, optional
        Further masses at the sections [kg], such as a damper or gear at section 0.
    thrust_damping : float, optional
        Viscous damping of the thrust bearing [N s/m].
    damping : float or array_like of shape (n,), optional
        Viscous (relative) damping of each throw, or of all [N s/m].
    loss_factor : float or array_like of shape (n,), optional
        Hysteretic damping of each throw, or of all.
    section_damping : float or array_like of shape (n + 1,), optional
        Viscous (absolute) damping of each section, or of all, to ground [N s/m].
    shaft_line : Chain, optional
        Axial chain of the shaft line behind the flywheel; its first node becomes section n.

    Returns
    -------
    EngineChain
        n + 1 nodes [kg], n springs [N/m], and the thrust bearing to ground [N/m]; nodes of the
        shaft line after them.

    Raises
    ------
    InputError
        If a compliance or throw mass is not above zero, another value is negative, or lengths or
        the thrust node do not fit.
    """
    compliances = _checked_compliances(throw_compliances, "m/N")
    masses = positive_vector("throw_masses", throw_masses, "kg", "every throw has mass")
    check_one_each("throw_masses", masses.size, compliances.size, "throws")
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
    names = [f"main bearing {number}" for number in range(1, count + 2)]
    if flywheel_mass > 0.0:
        names[-1] += ", flywheel"
    if bearing > 0.0:
        names[thrust] += ", thrust bearing"
    held = nonnegative_number("thrust_damping", thrust_damping, "N s/m", "oil resists motion")
    at_thrust = np.arange(count + 1) == thrust
    absolute = one_for_each(
        "section_damping", section_damping, count + 1, "sections", "N s/m", PASSIVE
    )
    chain = Chain(
        at_sections,
        1.0 / compliances,
        bearing * at_thrust,
        damping=damping,
        loss_factor=loss_factor,
        ground_damping=absolute + held * at_thrust,
        names=names,
    )
    if damper is not None:
        check_axial(damper)
        chain = with_damper(chain, 0, damper)
    if shaft_line is not None:
        chain = join_chains(chain, count, shaft_line)
    return EngineChain(chain, "axial", sections=tuple(range(count + 1)))


def torsional_chain(
    throw_compliances: ArrayLike,
    throw_inertias: ArrayLike,
    flywheel_inertia: float,
    free_end_inertia: float = 0.0,
    driven: DrivenMachine | Sequence[DrivenMachine] | None = None,
    *,
    damping: ArrayLike = 0.0,
    loss_factor: ArrayLike = 0.0,
    throw_damping: ArrayLike = 0.0,
    cylinders: int | Sequence[int] = 1,
    damper: TorsionalDamper | None = None,
    shaft_line: Chain | None = None,
) -> EngineChain:
    """Build the torsional chain of an engine: one inertia at each crank, and its surroundings.

    Parameters
    ----------
    throw_compliances : array_like of shape (n,)
        Torsional compliance of each throw from journal middle to journal middle [rad/(N m)].
    throw_inertias : array_like of shape (n,)
        Moment of inertia of each throw with its share of rods and pistons [kg m^2], as
        `throw_inertia` or `throw_inertias` give it.
    flywheel_inertia : float
        Moment of inertia of the flywheel [kg m^2].
    free_end_inertia : float
        Moment of inertia at the free end, such as a pulley or damper hub [kg m^2]; 0 for none.
    driven : DrivenMachine or sequence of DrivenMachine, optional
        Driven machines and their couplings.
    damping : float or array_like of shape (e,), optional
        Viscous (relative) damping of each element of the crankshaft, or of all [N m s/rad].
    loss_factor : float or array_like of shape (e,), optional
        Hysteretic damping of each element of the crankshaft, or of all. There are n elements, and
        one more with a free end.
    throw_damping : float or array_like of shape (n,), optional
        Viscous (absolute) damping at each throw, or at all [N m s/rad].
    cylinders : int or sequence of n int, optional
        Number of cylinders on each throw, or on all. If it is one everywhere the nodes are
        called "cylinder 1" and so on, otherwise "throw 1" and so on.
    shaft_line : Chain, optional
        Torsional chain of the shaft line behind the flywheel; its first node becomes the flywheel.

    Returns
    -------
    EngineChain
        Free end if any, throws 1 to n, flywheel; then the nodes of damper, shaft line and driven
        machines, if any [kg m^2, N m/rad].

    Raises
    ------
    InputError
        If a compliance or an inertia is not above zero, a damping or the inertia at the free end
        is negative, lengths differ, or a damper has no free end with inertia to be mounted on.

    Notes
    -----
    The inertia of a throw is at its crank, in the middle of its compliance: throws i and
    i + 1 are joined by half of either throw's compliance; free end and flywheel are joined by half
    of the adjacent throw; the journal stubs beyond the last middles count as rigid.
    """
    compliances = _checked_compliances(throw_compliances, "rad/(N m)")
    inertias = positive_vector(
        "throw_inertias", throw_inertias, "kg m^2", "every throw has inertia"
    )
    check_one_each("throw_inertias", inertias.size, compliances.size, "throws")
    flywheel = positive_number(
        "flywheel_inertia", flywheel_inertia, "kg m^2", "the chain ends at the flywheel"
    )
    free_end = nonnegative_number(
        "free_end_inertia", free_end_inertia, "kg m^2", "it is that of a body, or none"
    )
    if damper is not None:
        check_torsional(damper)
        if free_end + damper.hub_inertia == 0.0:
            raise InputError(
                "free_end_inertia: given 0 with a damper without hub_inertia; allowed is more than zero "
                "for one of them, because the damper sits on the free end."
            )
    count = compliances.size
    names = throw_names(cylinders, count)
    absolute = one_for_each("throw_damping", throw_damping, count, "throws", "N m s/rad", PASSIVE)
    halves = compliances / 2.0
    joined = np.array([*(halves[:-1] + halves[1:]), halves[-1]])
    if damper is not None:
        free_end += damper.hub_inertia
        damper = damper.changed(hub_inertia=0.0)
    ends = [free_end] if free_end > 0.0 else []
    if ends:
        joined = np.array([halves[0], *joined])
    chain = Chain(
        [*ends, *inertias, flywheel],
        1.0 / joined,
        damping=damping,
        loss_factor=loss_factor,
        ground_damping=[*(0.0 for _ in ends), *absolute, 0.0],
        names=[*(FREE_END for _ in ends), *names, FLYWHEEL],
    )
    if shaft_line is not None:
        chain = join_chains(chain, FLYWHEEL, shaft_line)
    machines = (driven,) if isinstance(driven, DrivenMachine) else tuple(driven or ())
    for machine in machines:
        chain = machine.attached(chain)
    if damper is not None:
        chain = with_damper(chain, FREE_END, damper)
    throws = tuple(range(len(ends), len(ends) + count))
    return EngineChain(chain, "torsional", throw_nodes=throws)


def throw_names(cylinders: int | Sequence[int], count: int) -> list[str]:
    """Return the names of the cranks' nodes, from the free end."""
    counts = [cylinders] * count if isinstance(cylinders, int | np.integer) else list(cylinders)
    if len(counts) != count:
        raise InputError(
            f"cylinders: given {len(counts)} values; allowed are {count}, or one for all, because "
            "there is one for each throw."
        )
    on_each = [whole_number("cylinders", value, 1, "a throw carries cylinders") for value in counts]
    word = "cylinder" if max(on_each) == 1 else "throw"
    return [f"{word} {number}" for number in range(1, count + 1)]


def _checked_compliances(throw_compliances: ArrayLike, unit: str) -> Array:
    compliances = positive_vector(
        "throw_compliances", throw_compliances, unit, "every throw yields under load"
    )
    check_some("throw_compliances", compliances, "a crankshaft has a throw")
    return compliances


Reciprocating = Literal["half", "mean"]
# The reduced inertia is smooth and periodic: its mean over even angles converges exponentially.
MEAN_ANGLES = 360


def throw_inertia(
    solid_inertia_about_shaft: float,
    rod_rotating_mass: ArrayLike,
    reciprocating_mass: ArrayLike,
    crank_radius: float,
) -> float:
    """Return the equivalent constant moment of inertia of a throw with its rods and pistons.

    Parameters
    ----------
    solid_inertia_about_shaft : float
        Moment of inertia of the solid throw about the shaft axis, counterweights included
        [kg m^2].
    rod_rotating_mass : float or array_like
        Share of the connecting rod that rotates with the crankpin [kg]; one value for each rod where
        a throw carries several.
    reciprocating_mass : float or array_like
        Piston with pin, and the share of the rod that moves with it [kg]; one for each cylinder.
    crank_radius : float
        R [m].

    Returns
    -------
    float
        I + m_rot R^2 + m_rec R^2 / 2, summed over the cylinders [kg m^2].

    Raises
    ------
    InputError
        If the inertia or the radius is not above zero, or a mass is negative.

    Notes
    -----
    The piston moves by R (sin a + (lambda / 2) sin 2a) per radian of crank angle, so that its
    inertia at the shaft varies over the revolution; half of the reciprocating mass is the mean of
    that over the cycle to zeroth order in the crank ratio lambda (the next term is
    m_rec R^2 lambda^2 / 8). `throw_inertias` gives the exact mean, for hinged rods too. The
    variation itself, which excites secondary resonances in slow engines with heavy pistons, is
    not included in a chain of constant inertias.
    """
    solid = positive_number(
        "solid_inertia_about_shaft", solid_inertia_about_shaft, "kg m^2", "every throw has inertia"
    )
    rotating = _masses("rod_rotating_mass", rod_rotating_mass)
    reciprocating = _masses("reciprocating_mass", reciprocating_mass)
    R = positive_number("crank_radius", crank_radius, "m", "the stroke is twice as long")
    return float(solid + (rotating.sum() + reciprocating.sum() / 2.0) * R**2)


def throw_inertias(
    engine: EngineLayout,
    solid_inertias: ArrayLike,
    *,
    reciprocating: Reciprocating = "half",
    throws: Sequence[int] | None = None,
) -> Array:
    """Return the constant inertia of each throw of an engine with its rods and pistons.

    Parameters
    ----------
    solid_inertias : float or array_like of shape (t,)
        Moment of inertia of each solid throw about the shaft axis, counterweights included, or of
        all [kg m^2].
    reciprocating : {"half", "mean"}, optional
        "half" replaces the rod by two masses at its pins, and takes half of the mass that moves with the
        piston (for a hinged rod, with the slave pin as if it were at the crankpin). "mean" takes the
        mean over a revolution of the inertia exactly reduced to the crank, with rigid rods.
    throws : sequence of n int, optional
        Throw of each cylinder, from 0 at the free end; by default found from positions and angles.

    Returns
    -------
    ndarray of shape (t,)
        [kg m^2]

    Raises
    ------
    InputError
        If the choice is unknown, the lengths differ, or an inertia is not above zero.

    Notes
    -----
    Exactly, a cylinder contributes m_p |x_p'|^2 + m |x_c'|^2 + J beta'^2, primes being derivatives by
    the shaft angle: piston, rod's center, rod's rotation.
    """
    why = "these are the constants that represent the inertia of pistons"
    check_choice("reciprocating", reciprocating, get_args(Reciprocating), why)
    groups = throws_along_shaft(engine) if throws is None else checked_throws(engine, throws)
    solids = one_for_each(
        "solid_inertias",
        solid_inertias,
        len(groups),
        "throws",
        "kg m^2",
        "every throw has inertia",
        zero_allowed=False,
    )
    angles = even_angles(2.0 * np.pi, MEAN_ANGLES)
    inertias = []
    for number, cylinder in enumerate(engine.cylinders, start=1):
        rod = cylinder.rod
        if reciprocating == "half":
            at_piston = rod.mass * rod.center_distance / rod.length
            moving = cylinder.piston_mass + at_piston
            inertias.append((rod.mass - at_piston + moving / 2.0) * engine.crank_radius**2)
        else:
            inertias.append(float(np.mean(cylinder_inertia(engine, number, rod, angles))))
    shares = [sum(inertias[number - 1] for number in group) for group in groups]
    return np.asarray(solids + np.array(shares))


def cylinder_inertia(
    engine: EngineLayout, number: int, rod: ConnectingRod | RodModel, angles: Array
) -> Array:
    """Return the inertia of a cylinder's piston and rod, reduced to the crank, over its angle.

    Parameters
    ----------
    angles : ndarray of shape (m,)
        Of the shaft [rad].

    Returns
    -------
    ndarray of shape (m,)
        m_p |x_p'|^2 + m |x_c'|^2 + J beta'^2, primes being derivatives by the shaft angle: piston,
        rod's center, rod's rotation [kg m^2].
    """
    motion = parts_motion(engine, number, angles)
    inertia = engine.cylinders[number - 1].piston_mass * np.abs(motion.piston.first) ** 2
    inertia += rod.mass * np.abs(motion.rod_point(rod.center).first) ** 2
    return np.asarray(inertia + rod.inertia * motion.rod.first**2)


def _masses(field: str, masses: ArrayLike) -> Array:
    why = "it adds to the inertia of the throw"
    checked = finite_array(field, masses)
    if checked.ndim == 0:
        return np.array([nonnegative_number(field, float(checked), "kg", why)])
    return nonnegative_vector(field, checked, "kg", why)
