"""Complex amplitudes of orders where a sensor is, and their exact slopes to every group of values."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any, Literal

import numpy as np

from crankbase.array_checks import Array, ComplexArray, Flags, Integers
from crankbase.errors import InputError
from crankfem.satellites.measured.calibration.groups import (
    EXCITATION,
    MODAL,
    Group,
    MovedValues,
    moved_values,
    values_of,
)
from crankfem.satellites.measured.measured_orders import Measurand
from dynamics.chains.chain import Chain
from dynamics.chains.varying import VaryingPart, over_amplitude
from dynamics.indices import index_of_name
from dynamics.response.harmonic import harmonic_response
from dynamics.response.linear_system import LinearSystem, natural_modes

# Inertia spread evenly along an element, seen from its ends.
ALONG = np.array([[2.0, 1.0], [1.0, 2.0]]) / 6.0


@dataclass(frozen=True, eq=False)
class Excitation:
    """Exciting torques at the points (N,) of a record.

    Parameters
    ----------
    fixed : complex ndarray of shape (N, n)
        On the nodes, of what has no gain, such as inertia forces [N m].
    sources : complex ndarray of shape (N, c)
        Of each source with a gain, such as the gas in a cylinder [N m].
    nodes : tuple of c int
        Node on which each acts.
    """

    fixed: ComplexArray
    sources: ComplexArray
    nodes: tuple[int, ...]

    def at(self, points: Integers) -> "Excitation":
        """Return the torques at some of the points."""
        return replace(self, fixed=self.fixed[points], sources=self.sources[points])


@dataclass(frozen=True)
class Sensor:
    """Where and what is measured: a node by its motion, or an element by the torque that strains it.

    Parameters
    ----------
    place : int
        Node or element, from 0.
    kind : {"node", "element"}
    """

    place: int
    kind: Literal["node", "element"] = "node"

    @classmethod
    def of(cls, chain: Chain, quantity: Measurand, place: str) -> "Sensor":
        """Return the sensor of a quantity at a place by its name.

        Raises
        ------
        InputError
            If the chain has no such place, or the quantity is none of a torsional chain.
        """
        if quantity not in ("angle", "torque"):
            raise InputError(
                f"{place or 'record'}: given orders of {quantity}; allowed are those of an angle or torque, "
                "because the torsional chain is fitted to them."
            )
        names = chain.names if quantity == "angle" else chain.elements
        why = "one of them carries the sensor"
        number = index_of_name("place", place, names, "the chain's places", why)
        return cls(number, "node" if quantity == "angle" else "element")


@dataclass(frozen=True, eq=False)
class Shaft:
    """A torsional chain with all of its damping, its excitation's sources, and groups that may move.

    Parameters
    ----------
    chain : Chain
    groups : tuple of p Group
    sources : int
        Number of sources of excitation, whose gains are 1.
    modal_damping : float
        Share of critical damping of every elastic mode, by its share of strain in the springs of `damps`.
    damps : ndarray of shape (e + n,), bool
        Springs, of elements then to ground, for which modal damping stands; all by default.
    """

    chain: Chain
    groups: tuple[Group, ...]
    sources: int = 1
    modal_damping: float = 0.0
    damps: Flags = field(default_factory=lambda: np.ones(0, dtype=bool))

    def __post_init__(self) -> None:
        moving = {act.field for group in self.groups for act in group.acts}
        for spring in self.chain.varying:
            if over_amplitude(spring.law) or not isinstance(spring.law, VaryingPart):
                raise InputError(
                    "chain: given a spring that varies over its amplitude, or by another law; allowed are "
                    "those that vary over frequency, speed, torque and temperature, because slopes are exact "
                    "for a linear chain."
                )
        if self.modal_damping and self.chain.varying and moving - {EXCITATION}:
            # The modes to which the damping belongs would be those of one frequency alone.
            raise InputError(
                "chain: given modal damping together with springs that vary; allowed is one of them, with "
                "damping of nodes and elements, because a mode of such a chain changes over the speed."
            )

    @cached_property
    def nominal(self) -> dict[str, Array]:
        """Values of the chain, of its modal damping and of the gains, which groups act on."""
        return {
            **values_of(self.chain),
            MODAL: np.array([self.modal_damping]),
            EXCITATION: np.ones(self.sources),
        }

    def moved(self, parameters: Array) -> MovedValues:
        """Return the values at parameters (p,), and their slopes."""
        return moved_values(self.nominal, self.groups, parameters)

    def chain_at(self, parameters: Array) -> Chain:
        """Return the chain with its moved values; its law of a varying spring moves with it."""
        return chain_with(self.chain, self.moved(parameters).values)

    def amplitudes(
        self, parameters: Array, sensor: Sensor, w: Array, speeds: Array, excitation: Excitation
    ) -> tuple[ComplexArray, ComplexArray]:
        """Return amplitudes at points (N,), and their slopes to the parameters.

        Parameters
        ----------
        parameters : ndarray of shape (p,)
            Logarithms of the groups' factors, in standard deviations.
        w, speeds : ndarray of shape (N,)
            Angular frequency of vibration and speed of the shaft [rad/s].

        Returns
        -------
        amplitudes : complex ndarray of shape (N,)
            [rad or N m].
        slopes : complex ndarray of shape (N, p)

        Notes
        -----
        With the dynamic stiffness D, symmetric, D x = f and the sensor's row c, the amplitude is y = c x.
        With D a = c, dy = dc x - a dD x + a df: one more solution gives the slopes to all groups.
        """
        made = self.moved(parameters)
        values, slopes = made.values, made.slopes
        chain = chain_with(self.chain, values)
        system = _System(chain, float(values[MODAL][0]), self.damps)
        gains = values[EXCITATION]
        acting = excitation.fixed.copy()
        for source, node in enumerate(excitation.nodes):
            acting[:, node] += gains[source] * excitation.sources[:, source]
        row = np.zeros((w.size, len(chain.names)), dtype=np.complex128)
        laws = _Laws(chain, w, speeds)
        if sensor.kind == "node":
            row[:, sensor.place] = 1.0
        else:
            twist = chain.elongations()[sensor.place]
            row += laws.stiffness(sensor.place)[:, np.newaxis] * twist
        x = system.solved(w, speeds, acting)
        a = system.solved(w, speeds, row)
        y = np.einsum("ni,ni->n", row, x)
        dy = system.slopes(x, a, w, slopes, laws)
        if sensor.kind == "element":
            share = slopes["stiffness"][:, sensor.place] / values["stiffness"][sensor.place]
            dy += np.multiply.outer(y, share)
        by_source = a[:, list(excitation.nodes)] * excitation.sources
        return y, dy + by_source @ slopes[EXCITATION].T


def chain_with(chain: Chain, values: Mapping[str, Array]) -> Chain:
    """Return the chain with other values of all fields; springs that vary keep their course."""
    changed: dict[str, Any] = {
        name: values[name] for name in values if name not in ("dashpots", MODAL, EXCITATION)
    }
    dashpots = tuple(
        replace(dashpot, damping=float(damping))
        for dashpot, damping in zip(chain.dashpots, values["dashpots"], strict=True)
    )
    varying = []
    for spring in chain.varying:
        law, at = spring.law, spring.place
        assert isinstance(law, VaryingPart)
        names = ("ground", "ground_damping") if spring.to_ground else ("stiffness", "damping")
        course, loss = law.variation, law.loss_factor
        if not spring.to_ground and chain.loss_factor[at]:
            ratio = float(values["loss_factor"][at] / chain.loss_factor[at])
            loss *= ratio
            if course.loss_factor is not None:
                scaled = (np.array(course.loss_factor) * ratio).tolist()
                table = tuple(tuple(row) if isinstance(row, list) else row for row in scaled)
                course = course.changed(loss_factor=table)
        stiffness, damping = (float(values[name][at]) for name in names)
        moved = VaryingPart(course, stiffness, loss, damping, law.amplitudes)
        varying.append(replace(spring, law=moved))
    return replace(chain, dashpots=dashpots, varying=tuple(varying), **changed)


class _Laws:
    """Stiffness, loss factor and damping of every spring over the points, constant where none varies."""

    def __init__(self, chain: Chain, w: Array, speeds: Array) -> None:
        self._chain, self._points = chain, w.size
        self.varying = {
            (spring.place, spring.to_ground): spring.law.constants(w, speeds)
            for spring in chain.varying
            if isinstance(spring.law, VaryingPart)
        }

    def stiffness(self, element: int) -> Array:
        """Return the stiffness of an element at the points (N,)."""
        if (element, False) in self.varying:
            return self.varying[element, False][0]
        return np.full(self._points, self._chain.stiffness[element])


class _System:
    """The equations of motion at one state of the chain, in its leading nodes."""

    def __init__(self, chain: Chain, ratio: float, damps: Flags) -> None:
        self.chain, self.expand = chain, chain.expansion()
        rigid = chain.rigid_motions()[0][chain.leading_nodes]
        mass, stiffness, damping, loss = (
            self.expand.T @ matrix @ self.expand
            for matrix in (
                chain.mass_matrix(),
                chain.stiffness_matrix(),
                chain.damping_matrix(),
                chain.loss_matrix(),
            )
        )
        self.natural, self.shapes = natural_modes(mass, stiffness, rigid)
        self.rigid = rigid.shape[1]
        self.momenta = mass @ self.shapes
        rows = np.vstack((chain.elongations(), np.eye(len(chain.names)))) @ self.expand
        springs = np.concatenate((chain.stiffness, chain.ground))
        self.damps = damps if damps.size else np.ones(springs.size, dtype=bool)
        self.twists = rows @ self.shapes
        # Strain energy of each mode in the springs that the damping stands for, and its damping.
        self.strain = np.sum((self.damps * springs)[:, np.newaxis] * self.twists**2, axis=0)
        self.strain[: self.rigid] = 0.0
        self.ratio = ratio
        self.modal = 2.0 * ratio * self.strain / np.where(self.natural > 0.0, self.natural, 1.0)
        self.system = LinearSystem(
            mass=mass,
            stiffness=stiffness,
            damping=damping + (self.momenta * self.modal) @ self.momenta.T,
            loss=loss,
            rigid=rigid,
            expand=self.expand,
            natural=self.natural,
            shapes=self.shapes,
            varying=chain.varying_springs(self.expand),
        )

    def solved(self, w: Array, speeds: Array, forces: ComplexArray) -> ComplexArray:
        """Return the motions of all nodes (N, n) under forces on them (N, n)."""
        answer = harmonic_response(self.system, w, forces @ self.expand, "modal", speeds)
        return np.asarray(answer.motion @ self.expand.T)

    def slopes(
        self, x: ComplexArray, a: ComplexArray, w: Array, moved: Mapping[str, Array], laws: _Laws
    ) -> ComplexArray:
        """Return - a dD x for every group, (N, p), of motions x and a of the nodes (N, n)."""
        chain = self.chain
        twists = chain.elongations().T
        elements, nodes = (x @ twists) * (a @ twists), x * a
        dashed = chain.dashpot_elongations().T
        viscous = elements @ moved["damping"].T + nodes @ moved["ground_damping"].T
        viscous += ((x @ dashed) * (a @ dashed)) @ moved["dashpots"].T
        strained = elements @ (
            moved["stiffness"] * (1.0 + 1j * chain.loss_factor)
            + 1j * chain.stiffness * moved["loss_factor"]
        ).T.astype(np.complex128)
        strained += nodes @ moved["ground"].T
        ends = np.array(chain.connections, dtype=np.intp).reshape(-1, 2)
        along = np.einsum("nea,ab,neb->ne", x[:, ends], ALONG, a[:, ends])
        inertial = nodes @ moved["inertia"].T + along @ moved["distributed_inertia"].T
        change = strained + 1j * w[:, np.newaxis] * viscous - w[:, np.newaxis] ** 2 * inertial
        for (at, to_ground), (stiffness, loss, damping) in laws.varying.items():
            change += self._varied(
                at, to_ground, elements, nodes, w, moved, (stiffness, loss, damping)
            )
        if self.ratio:
            change += 1j * w[:, np.newaxis] * self._of_modal_damping(x, a, moved)
        return np.asarray(-change)

    def _varied(
        self,
        at: int,
        to_ground: bool,
        elements: ComplexArray,
        nodes: ComplexArray,
        w: Array,
        moved: Mapping[str, Array],
        values: Sequence[Array],
    ) -> ComplexArray:
        """Return what a spring that varies adds to the change beyond that of its constant values."""
        stiffness, loss, damping = values
        chain = self.chain

        def share(field: str) -> Array:
            value = float(getattr(chain, field)[at])
            return moved[field][:, at] / value if value else np.zeros(len(moved[field]))

        names = (
            ("ground", "", "ground_damping")
            if to_ground
            else ("stiffness", "loss_factor", "damping")
        )
        product = (nodes if to_ground else elements)[:, at]
        constant = (
            float(getattr(chain, names[0])[at]),
            0.0 if to_ground else float(chain.loss_factor[at]),
        )
        added = stiffness * (1.0 + 1j * loss) - constant[0] * (1.0 + 1j * constant[1])
        change = np.multiply.outer(added * product, share(names[0]))
        if not to_ground:
            lost = 1j * (stiffness * loss - constant[0] * constant[1])
            change += np.multiply.outer(lost * product, share("loss_factor"))
        viscous = 1j * w * (damping - float(getattr(chain, names[2])[at]))
        return np.asarray(change + np.multiply.outer(viscous * product, share(names[2])))

    def _of_modal_damping(
        self, x: ComplexArray, a: ComplexArray, moved: Mapping[str, Array]
    ) -> ComplexArray:
        """Return a dC x of the modal damping C = M V diag(g) V' M, (N, p).

        With modes V of unit modal mass and squares l of their frequencies, changes of stiffness and mass are
        B = V' dK V and E = V' dM V; the modes change by V Z with Z_ij = (B_ij - l_j E_ij) / (l_j - l_i)
        and Z_ii = -E_ii / 2, so V' dC V = (E + Z) g + g (E + Z)' + dg.
        """
        chain, count = self.chain, self.natural.size
        squares = self.natural**2
        gaps = squares[np.newaxis, :] - squares[:, np.newaxis]
        elastic = np.arange(count) >= self.rigid
        nodes = self.expand @ self.shapes
        ends = np.array(chain.connections, dtype=np.intp).reshape(-1, 2)
        # Coordinates of the modes: x = V (V' M x).
        lead = chain.leading_nodes
        left, right = a[:, lead] @ self.momenta, x[:, lead] @ self.momenta
        change = np.zeros((len(x), len(moved["inertia"])), dtype=np.complex128)
        for group in range(change.shape[1]):
            stiff = np.concatenate((moved["stiffness"][group], moved["ground"][group]))
            heavy, spread = moved["inertia"][group], moved["distributed_inertia"][group]
            b = self.twists.T @ (stiff[:, np.newaxis] * self.twists)
            e = nodes.T @ (heavy[:, np.newaxis] * nodes)
            e += np.einsum("eaq,ab,ebr,e->qr", nodes[ends], ALONG, nodes[ends], spread)
            z = np.divide(b - e * squares, gaps, out=np.zeros_like(b), where=gaps != 0.0)
            z[np.diag_indices(count)] = -0.5 * np.diag(e)
            rigid = np.ix_(~elastic, ~elastic)
            z[rigid] = -0.5 * e[rigid]
            weights = (self.damps * np.concatenate((chain.stiffness, chain.ground)))[:, np.newaxis]
            strain = np.sum((self.damps * stiff)[:, np.newaxis] * self.twists**2, axis=0)
            strain += 2.0 * np.sum(weights * self.twists * (self.twists @ z), axis=0)
            frequency = np.where(elastic, self.natural, 1.0)
            faster = 0.5 * (np.diag(b) - squares * np.diag(e)) / frequency
            rate = 2.0 * self.ratio * (strain / frequency - self.strain * faster / frequency**2)
            rate += moved[MODAL][group, 0] / self.ratio * self.modal
            turned = (e + z) * self.modal
            whole = turned + turned.T + np.diag(np.where(elastic, rate, 0.0))
            change[:, group] = np.einsum("ni,ni->n", left @ whole, right)
        return change
