"""A chain of inertias and springs, torsional or axial: its description and its matrices."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import ArrayLike

from crankbase.array_checks import (
    Array,
    Flags,
    Integers,
    finite_vector,
    nonnegative_vector,
    one_for_each,
    positive_number,
    positive_vector,
    read_only,
)
from crankbase.choices import check_kind, check_some, so_many
from crankbase.errors import InputError, SolveError
from crankbase.summaries import summarized
from dynamics.chains.chain_modes import (
    Modes,
    eigen_residual,
    elastic_modes,
    pair_zero_crossings,
    row_zero_crossings,
    scaled,
    with_accurate_tails,
)
from dynamics.chains.varying import Varying, VaryingSpring
from dynamics.indices import node_index, values_at_nodes

Pairs = tuple[tuple[int, int], ...]
# Ratios of two ways through gears count as equal within this.
EQUAL_RATIOS = 1e-9


@dataclass(frozen=True)
class Dashpot:
    """Viscous damping between two nodes that no spring joins, as in a viscous damper.

    Parameters
    ----------
    left, right : int
        Nodes, from 0.
    damping : float
        Torque or force per relative speed [N m s/rad or N s/m].
    """

    left: int
    right: int
    damping: float

    def __post_init__(self) -> None:
        positive_number(
            "dashpot.damping",
            self.damping,
            "N m s/rad (torsional) or N s/m (axial)",
            "a dashpot resists motion",
        )


@dataclass(frozen=True)
class Gear:
    """Two nodes whose motions keep a fixed ratio, as those of meshing gears do.

    Parameters
    ----------
    driver, driven : int
        Nodes, from 0.
    ratio : float
        Motion of the driven node per motion of the driver: their speed ratio, negative where the
        sense changes; teeth of the driver over teeth of the driven gear in size.

    Raises
    ------
    InputError
        If the ratio is zero or not finite.
    """

    driver: int
    driven: int
    ratio: float

    def __post_init__(self) -> None:
        value = finite_vector("gear.ratio", [self.ratio])
        if value[0] == 0.0:
            raise InputError(
                "gear.ratio: given 0; allowed is a finite number other than zero, because the "
                "driven gear turns."
            )


def checked_pairs(connections: Sequence[tuple[int, int]] | None, count: int) -> Pairs:
    """Return the pairs of nodes that springs join; by default the neighbors in a row."""
    if connections is None:
        return tuple(pairwise(range(count)))
    return tuple(
        _pair(f"connections[{place}]", pair, count) for place, pair in enumerate(connections)
    )


def check_links(dashpots: Sequence[Dashpot], gears: Sequence[Gear], count: int) -> None:
    """Check the nodes of dashpots and gears."""
    for field, links, kind, example in (
        ("dashpots", dashpots, Dashpot, "Dashpot(left=0, right=1, damping=20.0)"),
        ("gears", gears, Gear, "Gear(driver=1, driven=2, ratio=-0.6)"),
    ):
        check_kind(field, links, Sequence, f"a sequence of {kind.__name__}")
        for place, link in enumerate(links):
            check_kind(f"{field}[{place}]", link, kind, f"a {kind.__name__}, like {example}")
    for place, dashpot in enumerate(dashpots):
        _pair(f"dashpots[{place}]", (dashpot.left, dashpot.right), count)
    for place, gear in enumerate(gears):
        _pair(f"gears[{place}]", (gear.driver, gear.driven), count)


def _pair(field: str, pair: Sequence[int], count: int) -> tuple[int, int]:
    if np.ndim(pair) != 1 or len(pair) != 2:
        raise InputError(f"{field}: given {pair!r}; allowed are two node numbers.")
    left, right = (node_index(field, node, count) for node in pair)
    if left == right:
        raise InputError(
            f"{field}: given node {left} twice; allowed are two different nodes, because what joins "
            "a node to itself does nothing."
        )
    return left, right


def speed_ratios(pairs: Pairs, gears: Sequence[Gear], count: int) -> tuple[Integers, Array]:
    """Find which nodes springs and gears connect, and their relative speeds in rigid motion.

    Returns
    -------
    parts : ndarray of shape (n,)
        Number of the part of each node, from 0, in the order of first nodes.
    ratios : ndarray of shape (n,)
        Motion of each node per motion of its part's first node.
    """
    neighbors: list[list[tuple[int, float]]] = [[] for _ in range(count)]
    for left, right in pairs:
        neighbors[left].append((right, 1.0))
        neighbors[right].append((left, 1.0))
    for gear in gears:
        neighbors[gear.driver].append((gear.driven, gear.ratio))
        neighbors[gear.driven].append((gear.driver, 1.0 / gear.ratio))
    parts, ratios = np.full(count, -1, dtype=np.int64), np.ones(count)
    for first in range(count):
        if parts[first] >= 0:
            continue
        parts[first] = parts.max() + 1
        waiting = [first]
        while waiting:
            node = waiting.pop()
            for other, ratio in neighbors[node]:
                wanted = ratios[node] * ratio
                if parts[other] < 0:
                    parts[other], ratios[other] = parts[first], wanted
                    waiting.append(other)
                elif abs(ratios[other] - wanted) > EQUAL_RATIOS * abs(wanted):
                    raise InputError(
                        f"gears: given ratios by which node {other} turns {ratios[other]:g} or "
                        f"{wanted:g} times as fast as node {first}; allowed is one ratio on every "
                        "way, because otherwise the shafts lock."
                    )
    return parts, ratios


def check_connected(parts: Integers, dashpots: Sequence[Dashpot]) -> None:
    """Refuse a chain that is not connected."""
    reached = {0}
    pairs = [(int(parts[d.left]), int(parts[d.right])) for d in dashpots]
    for _ in pairs:
        for left, right in pairs:
            if left in reached or right in reached:
                reached |= {left, right}
    apart = [node for node, part in enumerate(parts.tolist()) if part not in reached]
    if apart:
        raise InputError(
            f"connections: given ones that do not join node {', '.join(map(str, apart))} to node 0; "
            "allowed is one connected chain, because separate parts do not move each other."
        )


# Residual that the modes must keep, relative to the largest eigenvalue; round-off leaves 1e-14.
RESIDUAL_LIMIT = 1e-10
DAMPING_UNIT = "N m s/rad (torsional) or N s/m (axial)"


@summarized("inertia", "stiffness", "connections", "gears", "dashpots", "loss_factor")
@dataclass(frozen=True, init=False, eq=False)
class Chain:
    """Inertias with springs between them: in a row, with branches, and with gears.

    Parameters
    ----------
    inertia : array_like of shape (n,)
        Moments of inertia [kg m^2] of a torsional chain, or masses [kg] of an axial one.
    stiffness : array_like of shape (e,)
        Stiffness of each element [N m/rad] or [N/m].
    ground : array_like of shape (n,) or mapping of int to float, optional
        Stiffness of each node to ground [N m/rad] or [N/m], or of single nodes by their
        number from 0. None by default.
    connections : sequence of e pairs of int, optional
        Nodes that each element joins; by default the chain is a row of n - 1 elements between
        neighbors.
    damping : float or array_like of shape (e,), optional
        Viscous (relative) damping of each element [N m s/rad] or [N s/m].
    loss_factor : float or array_like of shape (e,), optional
        Hysteretic damping of each element: its stiffness is k (1 + i loss_factor).
    ground_damping : array_like of shape (n,) or mapping of int to float, optional
        Viscous (absolute) damping of nodes to ground [N m s/rad] or [N s/m].
    distributed_inertia : array_like of shape (e,), optional
        Inertia spread evenly along each element [kg m^2] or [kg], by consistent mass: two elements
        of a uniform shaft are as accurate as ten lumps at nodes.
    dashpots : sequence of Dashpot, optional
        Viscous couplings without a spring, as between hub and ring of a viscous damper.
    gears : sequence of Gear, optional
        Rigid speed ratios between nodes.
    varying : sequence of Varying, optional
        Springs that vary with frequency or speed; modes are those with the constant stiffness.
    names : sequence of n str, optional
        Names of the nodes; "node 0" and so on by default.

    Raises
    ------
    InputError
        If an inertia or a stiffness is not above zero (an inertia may be zero where an element or a
        gear brings some, or of gears between springs), another value is negative, lengths do not fit, a
        value is not a finite number, the chain is not connected, or gears contradict each other.

    Examples
    --------
    >>> modes = Chain(inertia=[211.4, 8.3], stiffness=[9.775e6]).modes()
    >>> modes.frequencies.round(1).tolist()
    [0.0, 176.1]
    """

    inertia: Array
    stiffness: Array
    ground: Array
    connections: Pairs
    damping: Array
    loss_factor: Array
    ground_damping: Array
    distributed_inertia: Array
    dashpots: tuple[Dashpot, ...]
    gears: tuple[Gear, ...]
    varying: tuple[Varying, ...]
    names: tuple[str, ...]

    def __init__(
        self,
        inertia: ArrayLike,
        stiffness: ArrayLike,
        ground: ArrayLike | Mapping[int, float] | None = None,
        *,
        connections: Sequence[tuple[int, int]] | None = None,
        damping: ArrayLike = 0.0,
        loss_factor: ArrayLike = 0.0,
        ground_damping: ArrayLike | Mapping[int, float] | None = None,
        distributed_inertia: ArrayLike = 0.0,
        dashpots: Sequence[Dashpot] = (),
        gears: Sequence[Gear] = (),
        varying: Sequence[Varying] = (),
        names: Sequence[str] | None = None,
    ) -> None:
        unit = "N m/rad (torsional) or N/m (axial)"
        stiffnesses = positive_vector(
            "stiffness", stiffness, unit, "a spring without stiffness cuts the chain in two"
        )
        mass_unit = "kg m^2 (torsional) or kg (axial)"
        spread = _of_elements(
            "distributed_inertia", distributed_inertia, stiffnesses.size, mass_unit
        )
        why = "a node without inertia has no motion of its own"
        check = nonnegative_vector if np.any(spread) or gears else positive_vector
        inertias = check("inertia", inertia, mass_unit, why)
        check_some("inertia", inertias, "a chain has a node")
        count = inertias.size
        pairs = checked_pairs(connections, count)
        if stiffnesses.size != len(pairs):
            raise InputError(
                f"stiffness: given {so_many(stiffnesses.size)} for {count} inertias; allowed are exactly "
                f"{len(pairs)}, because "
                + (
                    "one spring joins each two neighbors."
                    if connections is None
                    else f"connections has {len(pairs)} pairs."
                )
            )
        check_links(dashpots, gears, count)
        values = {
            "inertia": read_only(inertias),
            "stiffness": read_only(stiffnesses),
            "ground": _to_ground("ground", ground, count, unit),
            "connections": pairs,
            "damping": _of_elements("damping", damping, len(pairs), DAMPING_UNIT),
            "loss_factor": _of_elements("loss_factor", loss_factor, len(pairs), ""),
            "ground_damping": _to_ground("ground_damping", ground_damping, count, DAMPING_UNIT),
            "distributed_inertia": spread,
            "dashpots": tuple(dashpots),
            "gears": tuple(gears),
            "varying": tuple(varying),
            "names": tuple(f"node {k}" for k in range(count)) if names is None else tuple(names),
        }
        if names is not None and (len(names) != count or len(set(names)) != count):
            raise InputError(
                f"names: given {len(names)} names, {len(set(names))} of them different; allowed is a "
                f"different one for each of the {count} nodes, because results are named by them."
            )
        for name, value in values.items():
            object.__setattr__(self, name, value)
        for spring in self.varying:
            node_index("varying", spring.place, count if spring.to_ground else len(pairs))
        parts, _ = speed_ratios(self.connections, self.gears, count)
        check_connected(parts, self.dashpots)
        if not np.all(inertias):
            self._check_moving(parts)

    def _check_moving(self, parts: Integers) -> None:
        """Refuse nodes without inertia of their own, of their elements or of gears that no springs lead."""
        groups, _, massless = self._gear_groups()
        bare = massless[groups]
        ends = np.array(self.connections, dtype=np.intp).reshape(-1, 2)
        geared = [node for gear in self.gears for node in (gear.driver, gear.driven)]
        led = np.isin(np.arange(bare.size), geared)
        led &= (groups != groups[0]) & np.isin(parts, parts[~bare]) & (self.ground_damping == 0.0)
        led[ends[self.damping > 0.0].ravel()] = False
        led[[node for link in self.dashpots for node in (link.left, link.right)]] = False
        for spring in self.varying:
            led[spring.place if spring.to_ground else ends[spring.place]] = False
        if np.any(bare & ~led):
            node = int(np.flatnonzero(bare & ~led)[0])
            raise InputError(
                f"inertia[{node}]: given 0; allowed is more than zero where neither an element nor a gear "
                "brings inertia, or 0 of gears between springs without viscous damping that do not vary, "
                "but for the first node, because a node without inertia has no motion of its own."
            )

    def _gear_groups(self) -> tuple[Integers, Array, Flags]:
        """Return the group of each node, its motion per motion of the group, and which have no inertia."""
        groups, ratios = speed_ratios((), self.gears, self.inertia.size)
        loaded = self.inertia > 0.0
        if not np.all(loaded):
            loaded = np.diag(self.mass_matrix()) > 0.0
        return groups, ratios, ~np.isin(np.arange(groups.max() + 1), groups[loaded])

    @property
    def elements(self) -> tuple[str, ...]:
        """Names of the elements, such as "cylinder 1 - cylinder 2", (e,)."""
        return tuple(f"{self.names[a]} - {self.names[b]}" for a, b in self.connections)

    @property
    def is_row(self) -> bool:
        """Whether each element joins two neighbors, one after the other."""
        return self.connections == checked_pairs(None, self.inertia.size)

    @property
    def speed_ratios(self) -> Array:
        """Speed of each node relative to node 0 (to its part's first node), shape (n,)."""
        return speed_ratios(self.connections, self.gears, self.inertia.size)[1]

    @property
    def damped_springs(self) -> Flags:
        """Which springs have damping of their own: elements, then those of nodes to ground, (e + n,)."""
        beside = {frozenset((dashpot.left, dashpot.right)) for dashpot in self.dashpots}
        bridged = np.array([frozenset(pair) in beside for pair in self.connections], dtype=bool)
        between = (self.damping > 0.0) | (self.loss_factor > 0.0) | bridged
        return np.concatenate((between, (self.ground > 0.0) & (self.ground_damping > 0.0)))

    @property
    def has_massless_gears(self) -> bool:
        """Whether gears without inertia stand where springs lead them."""
        return bool(np.any(self._gear_groups()[2]))

    @property
    def leading_nodes(self) -> Integers:
        """Nodes whose motions are the unknowns that gears and nodes without inertia leave free, (q,)."""
        groups, _, massless = self._gear_groups()
        return np.unique(groups, return_index=True)[1][~massless]

    def expansion(self) -> Array:
        """Return T of shape (n, q): motions of the nodes per motion of the `leading_nodes`.

        Gears without inertia stand where the springs at them are in equilibrium, without the springs' loss
        factors: where these differ, the error of the stiffness is of the order of their difference squared.
        """
        groups, ratios, massless = self._gear_groups()
        expand = np.zeros((groups.size, massless.size))
        expand[np.arange(groups.size), groups] = ratios
        if np.any(massless):
            moving, bare = expand[:, ~massless], expand[:, massless]
            stiffness = self.stiffness_matrix()
            expand = moving - bare @ np.linalg.solve(
                bare.T @ stiffness @ bare, bare.T @ stiffness @ moving
            )
        return expand

    def elongations(self) -> Array:
        """Return the twist (lengthening) of each element per motion of each node, shape (e, n)."""
        return _differences(self.connections, self.inertia.size)

    def dashpot_elongations(self) -> Array:
        """Return the matrix (d, n) from displacements of the nodes to elongations of the dashpots."""
        pairs = [(dashpot.left, dashpot.right) for dashpot in self.dashpots]
        return _differences(pairs, self.inertia.size)

    def varying_springs(self, motions: Array) -> tuple[VaryingSpring, ...]:
        """Return the springs that vary, in unknowns that give the nodes these motions (n, q)."""
        nodes, elements = np.eye(self.inertia.size), self.elongations()
        return tuple(
            VaryingSpring((nodes if s.to_ground else elements)[s.place] @ motions, s.law)
            for s in self.varying
        )

    def mass_matrix(self) -> Array:
        """Return the inertia matrix M of the nodes, shape (n, n) [kg m^2 or kg]."""
        matrix = np.diag(self.inertia)
        for (left, right), share in zip(
            self.connections, self.distributed_inertia.tolist(), strict=True
        ):
            ends = [left, right]
            matrix[np.ix_(ends, ends)] += share / 6.0 * np.array([[2.0, 1.0], [1.0, 2.0]])
        return matrix

    def stiffness_matrix(self) -> Array:
        """Return the stiffness matrix K of the nodes, shape (n, n) [N m/rad or N/m]."""
        return self._of_elements_and_ground(self.stiffness, self.ground)

    def loss_matrix(self) -> Array:
        """Return H, the imaginary part of the stiffness by loss factors, shape (n, n)."""
        return self._of_elements_and_ground(
            self.stiffness * self.loss_factor, np.zeros(self.inertia.size)
        )

    def damping_matrix(self) -> Array:
        """Return the viscous damping matrix of the nodes, shape (n, n) [N m s/rad or N s/m]."""
        rows = self.dashpot_elongations()
        sizes = np.array([dashpot.damping for dashpot in self.dashpots])
        between = rows.T @ (sizes[:, np.newaxis] * rows)
        return between + self._of_elements_and_ground(self.damping, self.ground_damping)

    def rigid_motions(self) -> tuple[Array, tuple[str, ...]]:
        """Return the motions that no spring resists, as columns (n, r), and their names (r,)."""
        count = self.inertia.size
        parts, ratios = speed_ratios(self.connections, self.gears, count)
        held = set(parts[self.ground > 0.0].tolist())
        free = [part for part in range(int(parts.max()) + 1) if part not in held]
        motions = np.where(parts[:, np.newaxis] == free, ratios[:, np.newaxis], 0.0)
        if len(free) == 1 and np.all(motions):
            return motions, ("rigid body",)
        return motions, tuple(
            "rigid body: " + ", ".join(self.names[node] for node in np.flatnonzero(parts == part))
            for part in free
        )

    def modes(self) -> Modes:
        """Find all natural frequencies and mode shapes, K x = w^2 M x.

        Returns
        -------
        Modes
            q modes, ascending, one for each of the `leading_nodes`; that of a rigid body is exactly 0.

        Raises
        ------
        SolveError
            If the modes found do not satisfy the equation of motion.

        Notes
        -----
        The round-off error of all frequencies is relative to the highest one; see `elastic_modes`.
        Where a mode decays towards an end of a row or branch, its small displacements follow from the
        equations of the nodes there, so in a free chain mode j has exactly j nodes, as in theory.
        """
        expand, rows = self.expansion(), self.spring_rows()
        rigid, names = self.rigid_motions()
        mass, stiffness = self.mass_matrix(), self.stiffness_matrix()
        count = expand.shape[1] - rigid.shape[1]
        frequencies, reduced = elastic_modes(rows @ expand, expand.T @ mass @ expand, count)
        shapes = expand @ reduced
        parts, _ = speed_ratios(self.connections, self.gears, self.inertia.size)
        without_loops = len(self.connections) == self.inertia.size - int(parts.max()) - 1
        if without_loops and not self.gears:
            for shape, frequency in zip(shapes.T, frequencies.tolist(), strict=True):
                shape[:] = with_accurate_tails(shape, frequency, mass, stiffness, self.connections)
        shapes = scaled(np.column_stack((rigid, shapes)))
        frequencies = np.concatenate((np.zeros(rigid.shape[1]), frequencies))
        residual = eigen_residual(frequencies, shapes, mass, stiffness, expand)
        if not residual <= RESIDUAL_LIMIT:
            raise SolveError(
                f"The modes of the chain leave a residual of {residual:.1e} of the largest eigenvalue "
                f"(allowed {RESIDUAL_LIMIT:.0e})."
            )
        inertia_forces = mass @ shapes
        modal_inertia = np.sum(shapes * inertia_forces, axis=0)
        # A rigid body strains nothing; only round-off is there.
        energies = (rows @ shapes) ** 2 * (frequencies > 0.0)
        crossings = row_zero_crossings if self.is_row else pair_zero_crossings
        return Modes(
            angular_frequencies=read_only(frequencies),
            shapes=read_only(shapes),
            rigid=rigid.shape[1],
            node_positions=tuple(crossings(shape, self.connections) for shape in shapes.T),
            residual=residual,
            names=(*names, *(f"mode {number + 1}" for number in range(count))),
            modal_inertia=read_only(modal_inertia),
            kinetic_shares=read_only(shapes * inertia_forces / modal_inertia),
            strain_shares=read_only(
                energies / np.where(frequencies > 0.0, energies.sum(axis=0), 1.0)
            ),
            node_names=self.names,
            connections=self.connections,
        )

    def spring_rows(self) -> Array:
        """Return C with C' C = K: one row per element, then one per node, shape (e + n, n)."""
        between = np.sqrt(self.stiffness)[:, np.newaxis] * self.elongations()
        return np.vstack((between, np.diag(np.sqrt(self.ground))))

    def _of_elements_and_ground(self, elements: Array, ground: Array) -> Array:
        rows = self.elongations()
        return np.asarray(rows.T @ (elements[:, np.newaxis] * rows) + np.diag(ground))


def _differences(pairs: Sequence[tuple[int, int]], count: int) -> Array:
    """Return one row per pair: motion of its second node less that of its first."""
    rows = np.zeros((len(pairs), count))
    for row, (left, right) in zip(rows, pairs, strict=True):
        row[left], row[right] = -1.0, 1.0
    return rows


def _of_elements(field: str, values: ArrayLike, count: int, unit: str) -> Array:
    """Return one non-negative value per element; a single number applies to all."""
    why = "it is that of a passive element"
    return read_only(one_for_each(field, values, count, "elements", unit, why))


def _to_ground(
    field: str, values: ArrayLike | Mapping[int, float] | None, count: int, unit: str
) -> Array:
    return read_only(
        values_at_nodes(field, values, count, unit, "a support does not push a node away")
    )
