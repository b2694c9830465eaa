"""What records cannot tell of the groups, as directions; and which sensor or speed would tell it."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from crankbase.array_checks import Array
from crankfem.satellites.measured.calibration.fit import (
    Fit,
    Observation,
    Problem,
    without_constants,
)
from crankfem.satellites.measured.calibration.response_slopes import Excitation, Sensor

# Below this strength the records tell less of a direction than its prior does.
TELLS = 1.0
# Parts of a direction below this share of its largest are not named.
NAMED = 0.15
# A further sensor or speed tells it if the strength grows to this.
WOULD_TELL = 2.0
# Amplitudes below this are none [rad or N m].
TINY = 1e-300


@dataclass(frozen=True, eq=False)
class Direction:
    """A combination of groups, in deviations of the prior, and how strongly the records tell it.

    Attributes
    ----------
    parts : ndarray of shape (p,)
        Of unit length.
    strength : float
        Deviation of the prior over that of the records alone; 0 of an exact null direction.
    """

    parts: Array
    strength: float

    @property
    def untold(self) -> bool:
        """Whether the records tell less of it than the prior."""
        return self.strength < TELLS

    def named(self, fit: Fit) -> dict[str, float]:
        """Return the change of each group's factor, as a share, at one prior deviation along it."""
        groups = fit.problem.shaft.groups
        spread = np.array([group.deviation for group in groups])
        largest = np.max(np.abs(self.parts))
        return {
            group.name: float(np.expm1(spread[k] * self.parts[k]))
            for k, group in enumerate(groups)
            if abs(self.parts[k]) >= NAMED * largest
        }


def directions(fit: Fit) -> tuple[Direction, ...]:
    """Return the singular directions of the records alone in prior units, the weakest first.

    Zero angles that are not known are eliminated.
    """
    _, strengths, rows = np.linalg.svd(_own(fit.data, fit.problem.groups))
    # Fewer values than groups leave some directions without a strength.
    known = np.zeros(len(rows))
    known[: strengths.size] = strengths
    made = []
    for strength, parts in zip(known[::-1].tolist(), rows[::-1], strict=True):
        # The sign by which the largest part grows.
        sign = 1.0 if parts[np.argmax(np.abs(parts))] > 0.0 else -1.0
        made.append(Direction(sign * parts, strength))
    return tuple(made)


def _own(data: Array, groups: int) -> Array:
    """Return slopes (R, P) to the groups alone, without what the zero angles can do."""
    freed, angles = data[:, :groups], data[:, groups:]
    if angles.shape[1]:
        freed = freed - angles @ np.linalg.lstsq(angles, freed, rcond=None)[0]
    return np.asarray(np.linalg.qr(freed, mode="r"))


def _information(data: Array, groups: int) -> Array:
    """Return the information of slopes (R, P) on the groups alone, (p, p)."""
    freed = _own(data, groups)
    return np.asarray(freed.T @ freed)


@dataclass(frozen=True)
class Remedy:
    """A further measurement, and the strength with which it would tell a direction.

    Attributes
    ----------
    what : str
        Such as "the angle at flywheel" or "the angle at pulley at 1200 1/min".
    strength : float
        With what has been measured already.
    """

    what: str
    strength: float


Exciting = Callable[[Array, Array], Excitation]


@dataclass(frozen=True, eq=False)
class Further:
    """A further measurement, and the information (p, p) on the groups with it and all before."""

    what: str
    information: Array


def further_measurements(
    fit: Fit, speeds: Mapping[str, Array], excite: Exciting
) -> tuple[Further, ...]:
    """Return what each other sensor at the speeds of the first record, and its sensor at others, would add.

    Scatter is, as a share of each order, what the first record has. A wheel's constants are unknown at
    another node, and the same at further speeds of its own.

    Parameters
    ----------
    speeds : mapping
        Further speeds [rad/s], (m,), by what they are called.
    excite : callable
        The excitation at orders (k,) and speeds (m,).
    """
    problem, first = fit.problem, fit.problem.observations[0]
    chain, measured = problem.shaft.chain, first.measured
    have = {(each.sensor.kind, each.sensor.place) for each in problem.observations}
    before = _information(fit.data, problem.groups)
    made = []
    for kind, quantity, places in (
        ("node", "angle at", chain.names),
        ("element", "torque in", chain.elements),
    ):
        for place, name in enumerate(places):
            if (kind, place) in have:
                continue
            sensor = Sensor(place, "node" if kind == "node" else "element")
            flags = measured.wheel_constant if kind == "node" else measured.wheel_constant & False
            beside = replace(first, sensor=sensor, measured=replace(measured, wheel_constant=flags))
            made.append(Further(f"the {quantity} {name}", before + _expected(fit, beside)))
    without = before - _expected(fit, first)
    for what, over in speeds.items():
        every = np.concatenate((measured.speed, over))
        shape = (every.size, measured.orders.size)
        count = measured.speed.size
        correlation = np.eye(every.size)
        correlation[:count, :count] = measured.correlation
        more = replace(
            measured,
            speed=every,
            amplitude=np.zeros(shape, dtype=complex),
            scatter=np.ones(shape),
            correlation=correlation,
            ramp=np.zeros(every.size),
        )
        beside = replace(first, measured=more, excitation=excite(measured.orders, every))
        made.append(Further(what, without + _expected(fit, beside)))
    return tuple(made)


def remedies(direction: Direction, further: Sequence[Further]) -> tuple[Remedy, ...]:
    """Return the further measurements that would tell a direction, the best first."""
    strengths = [
        Remedy(each.what, _strength(direction.parts, each.information)) for each in further
    ]
    able = (remedy for remedy in strengths if remedy.strength >= WOULD_TELL)
    return tuple(sorted(able, key=lambda remedy: -remedy.strength))


def _strength(parts: Array, information: Array) -> float:
    """Return how strongly a direction is told, whatever the directions beside it are."""
    inverse = np.linalg.inv(information + np.eye(parts.size))
    # With the prior of deviation 1: its deviation over that of the records alone.
    left = float(parts @ inverse @ parts)
    return float(np.sqrt(max(1.0 / left - 1.0, 0.0)))


def _expected(fit: Fit, observation: Observation) -> Array:
    """Return the information (p, p) of an observation by its prediction, with the first record's scatter."""
    first = fit.problem.observations[0].measured
    size = np.sqrt(np.mean(np.abs(first.amplitude) ** 2, axis=0))
    relative = np.sqrt(np.mean(first.scatter**2, axis=0)) / np.maximum(size, TINY)
    problem, parameters = fit.problem_of(observation)
    y, _ = problem.predicted(parameters, 0)
    usual = relative * np.sqrt(np.mean(np.abs(y) ** 2, axis=0))
    scatter = np.broadcast_to(np.maximum(usual, TINY), y.shape)
    scaled = replace(
        observation, measured=replace(observation.measured, amplitude=y, scatter=scatter)
    )
    _, slopes = Problem(problem.shaft, (scaled,)).compared(parameters, 0)
    slopes = np.sqrt(scaled.measured.independent) * without_constants(scaled, slopes)
    return _information(slopes.reshape(-1, problem.size), problem.groups)
