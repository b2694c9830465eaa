"""An engine's torsional chain as a shaft to be calibrated: its damping, excitation and groups by name."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from crankbase.array_checks import Array, ComplexArray
from crankbase.choices import allowed_names
from crankbase.errors import InputError
from crankfem.analyses.shaft.chains import (
    engine_throw_inertias,
    engine_torsional_chain,
    magnifier_of,
)
from crankfem.analyses.shaft.throw_analyses import crank_analyses
from crankfem.analyses.vibration.engine_excitation import (
    engine_harmonics,
    failing_harmonics,
    forces_over_speeds,
    with_propeller,
)
from crankfem.analyses.vibration.run import EngineVibration
from crankfem.files.engine.engine_file import EngineFile
from crankfem.files.sections.excitation_sections import Misfire
from crankfem.satellites.measured.calibration.fit import Observation, Problem
from crankfem.satellites.measured.calibration.gains import cylinder_groups
from crankfem.satellites.measured.calibration.groups import (
    Group,
    chain_group,
    excitation_group,
    field_group,
    group_of_spread,
)
from crankfem.satellites.measured.calibration.response_slopes import Excitation, Sensor, Shaft
from crankfem.satellites.measured.measured_orders import MeasuredOrders, largest_lag
from dynamics.assessment.uncertainty import Kind, Spread
from dynamics.chains.chain import Chain
from dynamics.chains.engine_chains import EngineChain
from dynamics.excitation.chain_excitation import torque_excitation
from dynamics.excitation.cylinders import CylinderHarmonics
from dynamics.response.linear_system import DEFAULT_MAGNIFIER, MAGNIFIER_SOURCE

# Sections whose fields may move: they are parts of the chain, and change no force of a cylinder.
SECTIONS = ("flywheel", "free_end", "torsional_damper", "driven", "driver", "damping")
# Groups of [ranges], by its fields; and the gain of the gas in all cylinders.
RANGES: dict[str, Kind] = {
    "torsional_compliance": "compliance",
    "inertia": "inertia",
    "damping": "all damping",
}
GAS = "gas torque"
# Two orders are one within this share.
SAME_ORDER = 1e-9
# A ramp counts where its lag, n dOmega/dt / (zeta omega)^2, is below this: of a peak six times its cube is
# left.
LARGEST_LAG = 0.1
# Speeds beside each, as a share, for the change of the excitation.
BESIDE = 1e-3


@dataclass(frozen=True, eq=False)
class EngineModel:
    """An engine whose chain is fitted, by its vibration with the maker's values.

    A magnifier that is assumed stands for damping of springs without any of their own, as in the verdict.
    """

    run: EngineVibration

    @property
    def engine_file(self) -> EngineFile:
        """The engine with the maker's values."""
        return self.run.engine_file

    @cached_property
    def chain(self) -> EngineChain:
        """Its torsional chain, as the verdict has it."""
        return self.run.torsional.chosen.chain

    @cached_property
    def cylinders(self) -> tuple[str, ...]:
        """Names of the cylinders."""
        return tuple(f"cylinder {k + 1}" for k in range(self.engine_file.engine.cylinders))

    def chain_of(self, engine_file: EngineFile) -> EngineChain:
        """Return the chain of the engine with other parts, of the same throws."""
        cranks = crank_analyses(engine_file, self.run.analyses)
        inertias = engine_throw_inertias(
            engine_file, [crank.masses.inertia_about_shaft for crank in cranks]
        )
        return engine_torsional_chain(engine_file, self.run.torsional.chosen.compliances, inertias)

    def modal_damping(self, engine_file: EngineFile) -> float:
        """Return the share of critical damping that the magnifier adds to each mode."""
        magnifier, _, _ = magnifier_of(engine_file, "torsional")
        return 0.0 if magnifier is None else 0.5 / magnifier

    def shaft(self, groups: Sequence[Group]) -> Shaft:
        """Return the shaft with groups that may move."""
        chain = self.chain.chain
        _, _, assumed = magnifier_of(self.engine_file, "torsional")
        damps = np.ones(len(chain.stiffness) + len(chain.names), dtype=bool)
        if assumed:
            damps = ~chain.damped_springs
        count = len(self.cylinders)
        return Shaft(chain, tuple(groups), count, self.modal_damping(self.engine_file), damps)

    @cached_property
    def harmonics(self) -> CylinderHarmonics:
        """Those of the forces of its cylinders."""
        return engine_harmonics(self.engine_file)

    @cached_property
    def _forces(self) -> Callable[[Array], tuple[Array, ComplexArray, ComplexArray, Array]]:
        file, chain = self.engine_file, self.chain
        firing = self.harmonics
        dead = failing_harmonics(
            file, firing, misfire=Misfire(missing_share=1.0, compression=False)
        )

        def at(speeds: Array) -> tuple[Array, ComplexArray, ComplexArray, Array]:
            forces, still = (forces_over_speeds(file, each, speeds) for each in (firing, dead))
            whole = with_propeller(file, chain, torque_excitation(forces, chain))
            return forces.orders, forces.torque - still.torque, whole.forces, whole.orders

        return at

    def excitation(self, orders: Array, speeds: Array) -> Excitation:
        """Return the torques at orders (k,) and speeds (m,), of the gas in each cylinder by itself.

        Raises
        ------
        InputError
            If nothing excites an order, or a speed is outside the engine's pressure map.
        """
        over, back = np.unique(speeds, return_inverse=True)
        fired, gas, whole, known = self._forces(over)
        chain = self.chain
        nodes = tuple(chain.throw_nodes[throw] for throw in self.engine_file.throws)
        points = speeds.size, orders.size
        sources = np.zeros((*points, len(nodes)), dtype=np.complex128)
        fixed = np.zeros((*points, len(chain.nodes)), dtype=np.complex128)
        for place, order in enumerate(orders.tolist()):
            (at,) = np.nonzero(np.abs(known - order) <= SAME_ORDER * order)
            if not at.size:
                raise InputError(
                    f"orders: given {order:g}; allowed are those that excite this engine, up to "
                    f"{known[-1]:g}, because others have no calculated amplitude."
                )
            fixed[:, place] = whole[int(at[0])][back]
            (fires,) = np.nonzero(np.abs(fired - order) <= SAME_ORDER * order)
            if fires.size:
                sources[:, place] = gas[int(fires[0])][back]
                for cylinder, node in enumerate(nodes):
                    fixed[:, place, node] -= sources[:, place, cylinder]
        return Excitation(
            fixed.reshape(-1, len(chain.nodes)), sources.reshape(-1, len(nodes)), nodes
        )

    def group(self, name: str, tolerance: float) -> Group:
        """Return the group of a name: a field of the file, one of [ranges], the gas, or a part of the chain.

        Raises
        ------
        InputError
            If there is no such group, or it moves nothing.
        """
        chain, short = self.chain.chain, name.removeprefix("ranges.")
        if name == GAS:
            count = len(self.cylinders)
            return excitation_group(GAS, count, range(count), tolerance)
        if short in RANGES:
            return self._range(short, 1.0 / (1.0 + tolerance), 1.0 + tolerance)
        section, dot, field = name.partition(".")
        if not dot or " " in section:
            return chain_group(chain, name, tolerance)
        fields = getattr(self.engine_file, section, None) if section in SECTIONS else None
        if fields is None:
            known = [each for each in SECTIONS if getattr(self.engine_file, each) is not None]
            raise InputError(
                f"{name}: given as a group; {allowed_names(section, known)}, because these sections of the "
                "file are parts of the torsional chain."
            )
        value = getattr(fields, field, None)
        if not isinstance(value, float) or value <= 0.0:
            names = [each for each, number in dict(fields).items() if isinstance(number, float)]
            raise InputError(
                f"{name}: given as a group; {allowed_names(field, names)}, because a factor acts on a "
                "value of the file."
            )

        def chain_at(factor: float) -> tuple[Chain, float]:
            changed = self.engine_file.changed(**{section: {field: value * factor}})
            return self.chain_of(changed).chain, self.modal_damping(changed)

        return field_group(name, tolerance, chain_at)

    def _range(self, name: str, low: float, high: float) -> Group:
        """Return the group of a field of [ranges]."""
        places = tuple(range(self.chain.crank_elements)) if name == "torsional_compliance" else None
        spread = Spread(RANGES[name], low, high, places, f"ranges.{name}")
        return group_of_spread(self.chain.chain, spread)

    def groups(self, moves: Mapping[str, float], gains: bool = False) -> tuple[Group, ...]:
        """Return the groups of names with tolerances; without any those of the file's [ranges].

        Parameters
        ----------
        gains : bool, optional
            Whether each cylinder has a gain.

        Raises
        ------
        InputError
            As `group`, and if nothing may move.
        """
        made = [self.group(name, tolerance) for name, tolerance in moves.items()]
        ranges = self.engine_file.ranges
        if not moves and ranges is not None:
            for name in RANGES:
                factors = getattr(ranges, name)
                if factors is not None:
                    made.append(self._range(name, *factors))
        if not made and not gains:
            raise InputError(
                "--move: missing, and the file has no [ranges] of the torsional chain; allowed is what may "
                "move with its tolerance, like flywheel.inertia=5% or torsional_compliance=10%, because the "
                "maker's values are fitted within them."
            )
        return (*made, *(cylinder_groups(self.cylinders) if gains else ()))

    def observation(self, measured: MeasuredOrders) -> tuple[Observation, tuple[str, ...]]:
        """Return measured orders with what excites them, and remarks on what is left out.

        Raises
        ------
        InputError
            If no order of the record excites the engine, or its place is none of the chain.
        """
        orders, remarks = measured.orders, list(measured.notes)
        known = self._forces(np.unique(measured.speed)[:1])[3]
        near = np.min(np.abs(orders[:, np.newaxis] - known), axis=1) <= SAME_ORDER * orders
        if not np.any(near):
            raise InputError(
                f"{measured.place}: given orders {', '.join(f'{order:g}' for order in orders)}; allowed are "
                "some that excite this engine, because the others have no calculated amplitude."
            )
        if not np.all(near):
            left = ", ".join(f"{order:g}" for order in orders[~near])
            remarks.append(f"Orders {left} are left out: nothing calculated excites them.")
            measured = measured.part(columns=near)
        sensor = Sensor.of(self.chain.chain, measured.quantity, measured.place)
        lag = self._largest_lag(measured)
        if lag > LARGEST_LAG:
            raise InputError(
                f"{measured.place}: given a ramp whose resonances lag by {lag:.2f} (order times the change "
                f"of speed over the square of a mode's decay); allowed is up to {LARGEST_LAG:g}, because six "
                "times its cube is the share of a peak that is not known."
            )
        acting = self.excitation(measured.orders, measured.speed)
        growth = self._growth(measured) if np.any(measured.ramp) else None
        return Observation(measured, sensor, acting, growth=growth), tuple(remarks)

    def _growth(self, measured: MeasuredOrders) -> Excitation:
        """Return the change of the excitation with the speed, within the speeds measured."""
        speed = measured.speed
        ends = np.clip(np.outer((1.0 - BESIDE, 1.0 + BESIDE), speed), np.min(speed), np.max(speed))
        slow, fast = (self.excitation(measured.orders, each) for each in ends)
        apart = np.repeat(ends[1] - ends[0], measured.orders.size)[:, np.newaxis]
        apart[apart == 0.0] = np.inf
        return Excitation(
            (fast.fixed - slow.fixed) / apart, (fast.sources - slow.sources) / apart, fast.nodes
        )

    def _largest_lag(self, measured: MeasuredOrders) -> float:
        """Return how far a ramp's resonances are from steady ones, of the mode that lags most."""
        twisted = self.run.forced_torsional
        every = () if twisted is None else (*twisted.resonances, *twisted.started_through)
        peaks = (
            peak
            for peak in every
            if np.any(np.abs(measured.orders - peak.order) <= SAME_ORDER * peak.order)
        )
        return largest_lag(measured, peaks)


def engine_problem(
    model: EngineModel, records: Sequence[MeasuredOrders], groups: Sequence[Group]
) -> tuple[Problem, tuple[str, ...]]:
    """Return the problem of an engine and its records, and remarks."""
    pairs = [model.observation(record) for record in records]
    remarks = tuple(remark for _, each in pairs for remark in each)
    return Problem(model.shaft(groups), tuple(group for group, _ in pairs)), remarks


def with_magnifier(engine_file: EngineFile, names: Sequence[str]) -> EngineFile:
    """Return the engine with its magnifier given, where it is assumed and is to move."""
    field = "torsional_magnifier"
    damping = engine_file.damping
    stated = damping is not None and (damping.torsional_magnifier or damping.damps_torsion)
    if f"damping.{field}" in names and not stated:
        changed = engine_file.changed(damping={field: DEFAULT_MAGNIFIER})
        origin = {f"damping.{field}": (MAGNIFIER_SOURCE, True)}
        return replace(changed, provenance={**changed.provenance, **origin})
    return engine_file
