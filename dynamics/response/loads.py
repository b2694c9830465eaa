"""Vibratory torque or force in each element, the stress from it, and the power balance."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Literal, Unpack

import numpy as np
from numpy.typing import ArrayLike, NDArray

from crankbase.array_checks import Array, ComplexArray, Flags, finite_array, positive_vector
from crankbase.choices import check_choice, so_many
from crankbase.diagrams import new_axes, write_title
from crankbase.errors import InputError, SolveError
from crankbase.frames import Axes, Dataset, grid
from crankbase.results import result
from dynamics.chains.chain import Chain
from dynamics.chains.varying import Varying, VaryingSpring
from dynamics.indices import index_of_name
from dynamics.plots.curves import (
    KILO,
    Quantity,
    draw_named_curves,
    name_axis,
    orders_and_speeds,
    quantity_display,
)
from dynamics.response.forced import ForcedResponse
from dynamics.response.series import DrawnBeside, OrderSeries, with_unbounded


@result("elastic.orders", "elastic.speeds [rad/s]", "elastic.names")
class ElementLoads:
    """Loads [N m or N] by order and speed; each is a series that can be summed over the cycle.

    Parameters
    ----------
    elements : OrderSeries
        Total load of each element: (k (1 + i eta) + i w c) times its twist or
        lengthening d, the motion of its second node minus that of its first, less the force P with which
        it pushes its ends apart (`OrderExcitation.pressing`). Positive where it
        drives the first node forwards and holds the second one back.
    elastic : OrderSeries
        The part k d - P, which strains the element; the rest is loss factor and viscous damping.
    ground : OrderSeries
        Load of each node's spring and damper to ground, (g + i w c) x; zero at a
        node without.
    dashpots : OrderSeries
        Load of each dashpot, i w c times its relative motion.

    Notes
    -----
    Along an element with distributed inertia the load varies; k d is its mean.

    A throw whose pin carries Z lengthens by d = N / k + c Z under the axial force N through it, as nothing
    outside pulls at the pin: N = k d - P with P = k c Z. It equals what accelerates the masses beside it.
    """

    elements: OrderSeries
    elastic: OrderSeries
    ground: OrderSeries
    dashpots: OrderSeries

    def plot(
        self,
        axes: Axes | None = None,
        element: int | str = 0,
        *,
        quantity: Quantity | None = None,
        part: Literal["elastic", "elements", "ground", "dashpots"] = "elastic",
        **drawn: Unpack[DrawnBeside],
    ) -> Axes:
        """Draw one element's main orders, their synthesis and their plain sum over the speed.

        Parameters
        ----------
        element : int or str, optional
            By number from 0 or name; of nodes or dashpots for these parts.
        quantity
            As for `quantity_display`.
        part : {"elastic", "elements", "ground", "dashpots"}, optional
            Which of the four series.
        **drawn
            As `DrawnBeside` says: limits, barred, main_orders.

        Raises
        ------
        InputError
            If element, quantity or part is unknown, or a limit, range or number is invalid.
        """
        check_choice("part", part, PARTS, "one series is drawn")
        shown = quantity_display(quantity, "N m or N", "alternating load")
        series: OrderSeries = getattr(self, part)
        return series.draw(axes, element, shown, "element", **drawn)


PARTS = ("elastic", "elements", "ground", "dashpots")


def element_loads(response: ForcedResponse) -> ElementLoads:
    """Find the loads of all elements, connections to ground and dashpots of a chain.

    Raises
    ------
    InputError
        If the response is not that of a chain.
    """
    chain = chain_of(response)
    w = response.angular_frequencies[:, :, np.newaxis]
    twist = response.motion @ chain.elongations().T
    relative = response.motion @ chain.dashpot_elongations().T
    sizes = np.array([dashpot.damping for dashpot in chain.dashpots])

    def series(values: ComplexArray, names: tuple[str, ...]) -> OrderSeries:
        return OrderSeries(response.orders, response.speeds, values, response.unbounded, names)

    complex_stiffness = chain.stiffness * (1.0 + 1j * chain.loss_factor) + 1j * w * chain.damping
    ground = (chain.ground + 1j * w * chain.ground_damping) * response.motion
    elements = _less_pressing(complex_stiffness * twist, response)
    for spring, added in varying_stiffness(response):
        at = spring.place
        if spring.to_ground:
            ground[:, :, at] += added * response.motion[:, :, at]
        else:
            elements[:, :, at] += added * twist[:, :, at]
    return ElementLoads(
        elements=series(elements, chain.elements),
        elastic=series(elastic_loads(response), chain.elements),
        ground=series(ground, chain.names),
        dashpots=series(1j * w * sizes * relative, dashpot_names(chain)),
    )


def elastic_loads(response: ForcedResponse) -> ComplexArray:
    """Return the strain-related part of each element's load, (K, S, e): `ElementLoads.elastic` alone."""
    chain = chain_of(response)
    loads = np.asarray(response.motion @ (chain.elongations().T * chain.stiffness))
    for spring, added in varying_stiffness(response):
        if not spring.to_ground:
            twist = response.motion @ chain.elongations()[spring.place]
            loads[:, :, spring.place] += added.real * twist
    return _less_pressing(loads, response)


def _less_pressing(loads: ComplexArray, response: ForcedResponse) -> ComplexArray:
    """Return loads of all elements less the forces with which these push their ends apart."""
    pressing = response.excitation.pressing
    return loads if pressing is None else loads - pressing


def varying_stiffness(response: ForcedResponse) -> list[tuple[Varying, ComplexArray]]:
    """Return the springs of a chain that vary, and their stiffness beyond the constant one, (K, S)."""
    w = response.angular_frequencies
    speeds = np.tile(response.speeds, response.orders.size)
    return [
        (spring, spring.law.added(w.reshape(-1), speeds).reshape(w.shape))
        for spring in chain_of(response).varying
    ]


def section_modulus(
    kind: Literal["torsional", "axial"], diameter: ArrayLike, bore: ArrayLike = 0.0
) -> Array:
    """Return the divisor of a load for the nominal stress of round sections.

    Parameters
    ----------
    kind : {"torsional", "axial"}
        pi (D^4 - d^4) / (16 D) [m^3] for the shear stress at the surface under a torque, or the
        area pi (D^2 - d^2) / 4 [m^2] for the normal stress under a force.
    diameter, bore : float or array_like
        D and d [m].

    Raises
    ------
    InputError
        If a diameter is not above zero, a bore not from zero to below it, or the kind is unknown.
    """
    check_choice("kind", kind, ("torsional", "axial"), "a shaft is strained by torque or force")
    outer, inner = finite_array("diameter", diameter), finite_array("bore", bore)
    if np.any(outer <= 0.0):
        raise InputError(
            f"diameter: given {np.min(outer):g} m; allowed is more than zero, because a shaft has a section."
        )
    if np.any((inner < 0.0) | (inner >= outer)):
        raise InputError(
            f"bore: given {np.max(inner):g} m; allowed is from zero to below the diameter, because "
            "a shaft has a wall."
        )
    if kind == "axial":
        return np.asarray(np.pi / 4.0 * (outer**2 - inner**2))
    return np.asarray(np.pi / 16.0 * (outer**4 - inner**4) / outer)


def alternating_stress(
    loads: ElementLoads, sections: ArrayLike | Mapping[int, float] | Mapping[str, float]
) -> OrderSeries:
    """Return the nominal alternating stress [Pa] of elements, from the elastic part of their loads.

    Parameters
    ----------
    sections : array_like of shape (e,) or mapping of element to float
        Section modulus in torsion [m^3] of a torsional chain, or area [m^2] of an axial one, of
        every element; or of some by number from 0 or by name, where others have no shaft section.
        `section_modulus` gives it from diameters.

    Returns
    -------
    OrderSeries
        Of the elements given, in the order of the chain. Nominal: without
        stress concentration factors.

    Raises
    ------
    InputError
        If an element does not exist, a section is not above zero, or lengths do not fit.
    """
    names = loads.elastic.names
    if isinstance(sections, Mapping):
        why = "a stress is that of an element"
        by_place = {
            index_of_name("sections", key, names, "elements", why): float(value)
            for key, value in sections.items()
        }
        places = sorted(by_place)
        sizes = [by_place[place] for place in places]
    else:
        places, sizes = list(range(len(names))), np.asarray(sections).tolist()
    moduli = positive_vector(
        "sections", sizes, "m^3 (torsional) or m^2 (axial)", "stress is load over section"
    )
    if moduli.size != len(places):
        raise InputError(
            f"sections: given {so_many(moduli.size)} for {len(places)} elements; allowed is one for "
            "each, or some by their numbers or names, because each element has its own."
        )
    return OrderSeries(
        orders=loads.elastic.orders,
        speeds=loads.elastic.speeds,
        values=loads.elastic.values[:, :, places] / moduli,
        unbounded=loads.elastic.unbounded,
        names=tuple(names[place] for place in places),
    )


def chain_of(response: ForcedResponse) -> Chain:
    """Return the chain of a response."""
    if response.chain is None:
        raise InputError(
            "response: given that of a system of matrices; allowed is that of a chain, because matrices "
            "have no elements."
        )
    return response.chain


def dashpot_names(chain: Chain) -> tuple[str, ...]:
    """Return the names of the dashpots by those of their nodes, (d,)."""
    return tuple(
        f"{chain.names[dashpot.left]} - {chain.names[dashpot.right]}" for dashpot in chain.dashpots
    )


@dataclass(frozen=True, eq=False)
class LinearQuantities:
    """Quantities y = (rows + w^2 inertia) x + direct f of motion x and forces f at the frequency w.

    Parameters
    ----------
    names : tuple of p str
    rows : ndarray of shape (p, q)
        Per motion of the unknowns.
    loads : ndarray of shape (p,), bool
        Which are loads; the others are motions.
    inertia : ndarray of shape (p, q), optional
    direct : ndarray of shape (p, n), optional
        Per force, in the order of `OrderExcitation.acting`.
    varying : tuple of int and VaryingSpring
        Loads of springs that vary: that number of `rows` is for the constant stiffness alone.
    """

    names: tuple[str, ...]
    rows: Array
    loads: Flags
    inertia: Array | None = None
    direct: Array | None = None
    varying: tuple[tuple[int, VaryingSpring], ...] = ()

    def at(
        self, w: Array, speeds: Array, motion: ComplexArray, forces: ComplexArray
    ) -> ComplexArray:
        """Return all values (..., p) at frequencies (...) and speeds, which broadcast to them [rad/s]."""
        values = motion @ self.rows.T
        for place, spring in self.varying:
            flat = w.reshape(-1), np.broadcast_to(speeds, w.shape).reshape(-1)
            stiffness = spring.added(*flat).real.reshape(w.shape)
            values[..., place] += stiffness * (motion @ spring.row)
        if self.inertia is not None:
            values = values + w[..., np.newaxis] ** 2 * (motion @ self.inertia.T)
        return values if self.direct is None else values + forces @ self.direct.T

    def rows_at(self, places: NDArray[np.intp], w: Array, speeds: Array) -> Array:
        """Return rows + w^2 inertia of one quantity at each frequency and speed, (m, q)."""
        rows = self.rows[places]
        for place, spring in self.varying:
            stiffness = spring.added(w, speeds).real * (places == place)
            rows = rows + np.outer(stiffness, spring.row)
        return rows if self.inertia is None else rows + w[:, np.newaxis] ** 2 * self.inertia[places]

    def each(
        self,
        places: NDArray[np.intp],
        w: Array,
        speeds: Array,
        motion: ComplexArray,
        forces: ComplexArray,
    ) -> ComplexArray:
        """Return the value of one quantity at each frequency and speed, (m,)."""
        values = np.sum(motion * self.rows_at(places, w, speeds), axis=1)
        return np.asarray(
            values if self.direct is None else values + np.sum(forces * self.direct[places], axis=1)
        )

    def under(self, places: NDArray[np.intp]) -> "LinearQuantities":
        """Return the same for some of the forces."""
        return self if self.direct is None else replace(self, direct=self.direct[:, places])

    def series(self, response: ForcedResponse) -> OrderSeries:
        """Return them by order and speed, 0 where the response is unbounded."""
        forces = response.excitation.acting
        values = self.at(response.angular_frequencies, response.speeds, response.unknowns, forces)
        values = np.where(response.unbounded[:, :, np.newaxis], 0.0, values)
        return OrderSeries(response.orders, response.speeds, values, response.unbounded, self.names)


def load_quantities(
    response: ForcedResponse, elements: Sequence[int | str] | None = None
) -> LinearQuantities:
    """Return the loads k d - P of elements, as `ElementLoads.elastic`; of all elements by default."""
    chain = chain_of(response)
    why = "a load is that of an element"
    chosen = range(len(chain.elements)) if elements is None else elements
    places = [
        index_of_name("elements", element, chain.elements, "elements", why) for element in chosen
    ]
    rows = chain.stiffness[:, np.newaxis] * chain.elongations() @ response.system.expand
    springs = zip(chain.varying, chain.varying_springs(response.system.expand), strict=True)
    excitation, direct = response.excitation, None
    if excitation.pressing is not None:
        direct = np.zeros((len(places), excitation.acting.shape[2]))
        direct[range(len(places)), excitation.forces.shape[2] + np.array(places)] = -1.0
    return LinearQuantities(
        names=tuple(chain.elements[place] for place in places),
        rows=rows[places],
        loads=np.ones(len(places), dtype=bool),
        direct=direct,
        varying=tuple(
            (places.index(varying.place), spring)
            for varying, spring in springs
            if not varying.to_ground and varying.place in places
        ),
    )


def pushing(response: ForcedResponse) -> Array:
    """Return what of `OrderExcitation.acting` pushes elements' ends apart, as forces on the unknowns.

    Returns
    -------
    ndarray of shape (n + e, q)
        Per force; those on nodes push no element.
    """
    acting, expand = response.excitation.acting, response.system.expand
    rows = np.zeros((acting.shape[2], expand.shape[1]))
    if response.excitation.pressing is not None:
        rows[len(expand) :] = chain_of(response).elongations() @ expand
    return rows


def motion_rows(
    response: ForcedResponse, nodes: Sequence[int | str] | None = None
) -> tuple[Array, tuple[str, ...]]:
    """Return the motions of nodes relative to those of the rigid body, (p, q), and their names."""
    why = "an amplitude is that of a node"
    chosen = range(len(response.names)) if nodes is None else nodes
    places = [index_of_name("node", node, response.names, "nodes", why) for node in chosen]
    system = response.system
    rows = system.expand[places]
    rigid = system.shapes[:, : system.rigid.shape[1]]
    rows = rows - (rows @ rigid) @ (system.mass @ rigid).T
    return rows, tuple(response.names[place] for place in places)


def named_quantity(response: ForcedResponse, name: str) -> LinearQuantities:
    """Return the load, relative motion or motion of the element, dashpot or node of a name."""
    chain = response.chain
    if chain is not None and name in chain.elements:
        return load_quantities(response, [name])
    if chain is not None and name in (dashpots := dashpot_names(chain)):
        rows = chain.dashpot_elongations()[[dashpots.index(name)]] @ response.system.expand
        return LinearQuantities((name,), rows, np.ones(1, dtype=bool))
    if name in response.names:
        rows, names = motion_rows(response, [name])
        return LinearQuantities(names, rows, np.zeros(1, dtype=bool))
    raise InputError(
        f"place: given {name!r}; allowed are elements, dashpots and nodes of the response, because modes "
        "tell how these move."
    )


# Sums over a working cycle of some hundred angles and orders; round-off leaves 1e-10 and less.
LARGEST_POWER_ERROR = 1e-6
# Heat below this share of the apparent power is lost in the round-off of that.
NO_HEAT = 1e-10


@result("power_in [W]", "dissipated [W]", "error", "orders", "speeds [rad/s]")
class PowerBalance:
    """Mean power over the cycle [W] by order and speed; inf where the vibration is unbounded.

    Orders do not exchange power over a common cycle: the powers of all orders add up.

    Parameters
    ----------
    power_in : ndarray of shape (K, S)
        Power of the exciting forces.
    apparent : ndarray of shape (K, S)
        Half the product of force and speed amplitudes, summed over the nodes: the power if
        each force were in phase with the speed of its node.
    elements : ndarray of shape (K, S, e)
        Heat in each element, by viscous damping and loss factor.
    dashpots : ndarray of shape (K, S, d)
        Heat in each dashpot.
    ground : ndarray of shape (K, S, n)
        Heat in the damper to ground at each node.
    rest : ndarray of shape (K, S)
        Power dissipated by modal damping or a magnifier; for a system that is not a chain, by all damping.
    unbounded : ndarray of shape (K, S), bool
    element_names, dashpot_names, node_names : tuple of str
    orders : ndarray of shape (K,)
        In cycles per crankshaft revolution.
    speeds : ndarray of shape (S,)
        [rad/s].
    """

    power_in: Array
    apparent: Array
    elements: Array
    dashpots: Array
    ground: Array
    rest: Array
    unbounded: Flags
    element_names: tuple[str, ...]
    dashpot_names: tuple[str, ...]
    node_names: tuple[str, ...]
    orders: Array
    speeds: Array

    @property
    def dissipated(self) -> Array:
        """All heat together [W], (K, S); it equals the power of excitation."""
        heat = self.elements.sum(axis=2) + self.dashpots.sum(axis=2) + self.ground.sum(axis=2)
        return np.asarray(heat + self.rest)

    @property
    def error(self) -> float:
        """Largest difference of power in and heat at any speed, all orders together, as a share.

        Without damping, or if the heat is lost in round-off of the apparent power,
        as a share of the apparent power instead.
        """
        bounded = ~np.any(self.unbounded, axis=0)
        heat = self.dissipated[:, bounded].sum(axis=0)
        left = np.abs(self.power_in[:, bounded].sum(axis=0) - heat)
        apparent = self.apparent[:, bounded].sum(axis=0)
        whole = np.where(heat > NO_HEAT * apparent, heat, apparent)
        return float(np.max(left / np.where(whole > 0.0, whole, 1.0), initial=0.0))

    def plot(self, axes: Axes | None = None) -> Axes:
        """Draw the power of excitation and of all kinds of damping over the speed, all orders together.

        Returns
        -------
        matplotlib.axes.Axes
            Kinds of damping without power are left out.
        """
        axes = new_axes(axes)
        sinks = {
            "in elements": self.elements.sum(axis=2),
            "in dashpots": self.dashpots.sum(axis=2),
            "to ground": self.ground.sum(axis=2),
            "modal damping": self.rest,
        }
        curves = {"power in": KILO * self.power_in.sum(axis=0)}
        for name, values in sinks.items():
            if np.any(values[~self.unbounded]):
                curves[name] = KILO * values.sum(axis=0)
        draw_named_curves(axes, self.speeds, curves, "mean power [kW]")
        write_title(axes, "Power of vibration, all orders together")
        return axes

    def to_xarray(self) -> Dataset:
        """Return all powers over order, speed and place.

        Units and errors are those of `crankbase.frames.grid`.
        """
        plane = ("order", "speed")
        return grid(
            {
                "power_in": (plane, self.power_in, "W", "power of the exciting forces"),
                "apparent": (plane, self.apparent, "W", "power if all were in phase"),
                "elements": ((*plane, "element"), self.elements, "W", "heat in the element"),
                "dashpots": ((*plane, "dashpot"), self.dashpots, "W", "heat in the dashpot"),
                "ground": ((*plane, "node"), self.ground, "W", "heat in the damper to ground"),
                "rest": (plane, self.rest, "W", "modal damping"),
                "unbounded": (plane, self.unbounded, "1", "no steady vibration"),
            },
            {
                **orders_and_speeds(self.orders, self.speeds),
                "element": name_axis(self.element_names, "element"),
                "dashpot": name_axis(self.dashpot_names, "dashpot"),
                "node": name_axis(self.node_names, "node"),
            },
        )


def power_balance(response: ForcedResponse) -> PowerBalance:
    """Find the mean power of excitation and of all damping.

    Notes
    -----
    A force F exp(i w t) on a node that moves with X exp(i w t) does the mean work
    Re(F conj(i w X)) / 2 = w Im(F conj X) / 2 per second; a viscous damper c with the relative
    motion D turns c w^2 |D|^2 / 2 into heat and a loss factor on a stiffness k w k eta |D|^2 / 2.
    """
    w = response.angular_frequencies
    square = 0.5 * w[:, :, np.newaxis] ** 2
    forces, motion = response.excitation.forces, response.motion
    system, chain = response.system, response.chain
    work = 0.5 * w * np.sum((forces * np.conj(motion)).imag, axis=2)
    damping, loss = system.damping, system.loss
    none = np.zeros((*w.shape, 0))
    elements, dashpots, ground = none, none, np.zeros(motion.shape)
    names: tuple[tuple[str, ...], tuple[str, ...]] = ((), ())
    if chain is not None:
        twist = np.abs(motion @ chain.elongations().T) ** 2
        hysteretic = 0.5 * w[:, :, np.newaxis] * chain.stiffness * chain.loss_factor
        elements = (square * chain.damping + hysteretic) * twist
        sizes = np.array([dashpot.damping for dashpot in chain.dashpots])
        dashpots = square * sizes * np.abs(motion @ chain.dashpot_elongations().T) ** 2
        ground = square * chain.ground_damping * np.abs(motion) ** 2
        for spring, added in varying_stiffness(response):
            at, half = spring.place, 0.5 * w * added.imag
            if spring.to_ground:
                ground[:, :, at] += half * np.abs(motion[:, :, at]) ** 2
            else:
                elements[:, :, at] += half * twist[:, :, at]
        names = (chain.elements, dashpot_names(chain))
        expand = chain.expansion()
        # Exactly zero where nothing was added: the system was made by the same products.
        damping = damping - expand.T @ chain.damping_matrix() @ expand
        loss = loss - expand.T @ chain.loss_matrix() @ expand
    rest = square[:, :, 0] * _quadratic(damping, response.unknowns)
    rest = rest + 0.5 * w * _quadratic(loss, response.unknowns)
    if chain is None:
        speeds, moved = np.tile(response.speeds, len(w)), response.unknowns
        varying = system.varying_forces(w.reshape(-1), speeds, moved.reshape(w.size, -1))
        rest = rest + 0.5 * w * np.sum(np.conj(moved) * varying.reshape(moved.shape), axis=2).imag

    def endless(values: Array) -> Array:
        return with_unbounded(values, response.unbounded)

    return PowerBalance(
        power_in=endless(work),
        apparent=endless(0.5 * w * np.sum(np.abs(forces) * np.abs(motion), axis=2)),
        elements=endless(elements),
        dashpots=endless(dashpots),
        ground=endless(ground),
        rest=endless(rest),
        unbounded=response.unbounded,
        element_names=names[0],
        dashpot_names=names[1],
        node_names=response.names,
        orders=response.orders,
        speeds=response.speeds,
    )


def checked_power_balance(response: ForcedResponse) -> PowerBalance:
    """Return the result of `power_balance`, checked."""
    balance = power_balance(response)
    if not balance.error <= LARGEST_POWER_ERROR:
        raise SolveError(
            f"Power into the vibration and heat in its damping differ by a share of {balance.error:.1e} "
            f"(allowed {LARGEST_POWER_ERROR:.0e})."
        )
    return balance


def _quadratic(matrix: Array, motion: ComplexArray) -> Array:
    """Return x* A x of each motion (K, S, q)."""
    return np.asarray(np.sum((np.conj(motion) * (motion @ matrix)).real, axis=2))
