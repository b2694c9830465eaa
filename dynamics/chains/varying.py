"""Springs whose stiffness and damping vary with the frequency of vibration and the operating point."""

from dataclasses import dataclass, replace
from typing import Protocol, Self, TypeGuard, runtime_checkable

import numpy as np
from pydantic import model_validator

from crankbase.array_checks import Array, ComplexArray
from crankbase.choices import check_one_each
from crankbase.errors import InputError
from crankbase.model import InputModel, quantity_field

Table = tuple[float | tuple[float, ...], ...]
# Of springs of rubber or steel [K]: 50 K or 122 K is meant in degC or degF.
TEMPERATURES = (150.0, 700.0)


class StiffnessLaw(Protocol):
    """A complex stiffness that varies, as that of a coupling or a journal bearing."""

    def added(self, w: Array, speed: Array) -> ComplexArray:
        """Return what it is beyond the constant one [N m/rad or N/m], (m,).

        Parameters
        ----------
        w, speed : ndarray of shape (m,)
            Angular frequency of vibration and speed of the shaft [rad/s].
        """
        ...


@runtime_checkable
class AmplitudeLaw(StiffnessLaw, Protocol):
    """One that may depend on the amplitude of its elongation, all orders together."""

    @property
    def over_amplitude(self) -> bool:
        """Whether it does."""
        ...

    def at_amplitude(self, speeds: Array, amplitudes: Array) -> StiffnessLaw:
        """Return it with the amplitudes [rad or m] at ascending speeds [rad/s], (S,) each."""
        ...


def over_amplitude(law: StiffnessLaw) -> TypeGuard[AmplitudeLaw]:
    """Return whether a law depends on the amplitude."""
    return isinstance(law, AmplitudeLaw) and law.over_amplitude


@dataclass(frozen=True)
class Varying:
    """A spring of a chain that varies: an element, or that of a node to ground, by number from 0."""

    place: int
    law: StiffnessLaw
    to_ground: bool = False


@dataclass(frozen=True, eq=False)
class VaryingSpring:
    """The same in any system: its elongation per motion of the unknowns (q,), and its law.

    Of its stiffness, `constant` beyond the constant one of the law is part of the system's matrices.
    """

    row: Array
    law: StiffnessLaw
    constant: complex = 0j

    def added(self, w: Array, speed: Array) -> ComplexArray:
        """Return its stiffness beyond that in the matrices, at frequencies and speeds (m,) [rad/s]."""
        return self.law.added(w, speed) - self.constant


class Variation(InputModel):
    """How a spring and its damper vary over the frequency of vibration and the operating point.

    Over one quantity, or over two of them: then with a row for each point of the first, as they stand here.
    Between points values are linear, beyond them as at the first or last.
    """

    section = "variation"

    frequency: tuple[float, ...] | None = quantity_field(
        "ascending frequencies of vibration", "Hz", default=None
    )
    speed: tuple[float, ...] | None = quantity_field(
        "ascending speeds of the crankshaft", "rad/s", default=None
    )
    torque: tuple[float, ...] | None = quantity_field(
        "ascending mean torques in the spring", "N m", default=None
    )
    temperature: tuple[float, ...] | None = quantity_field(
        "ascending temperatures of the spring", "K", default=None
    )
    amplitude: tuple[float, ...] | None = quantity_field(
        "ascending amplitudes of its twist, all orders together; forced vibration of a chain alone",
        "rad",
        default=None,
    )
    stiffness: Table = quantity_field(
        "stiffness at each, over the constant one, which natural frequencies are calculated with",
        "",
    )
    loss_factor: Table | None = quantity_field(
        "loss factor at each, in place of the constant one", "", default=None
    )
    damping: Table | None = quantity_field(
        "viscous damping at each, over the constant one", "", default=None
    )
    at_torque: float | tuple[float, ...] | None = quantity_field(
        "mean torque that it carries, one or at each of at_speed; by default, of a driven machine, the rated "
        "one by the law of the load",
        "N m",
        default=None,
    )
    at_speed: tuple[float, ...] | None = quantity_field(
        "ascending speeds of the crankshaft at which at_torque is given", "rad/s", default=None
    )
    at_temperature: float | None = quantity_field(
        "temperature that it has", "K", *TEMPERATURES, default=None
    )

    @property
    def axes(self) -> dict[str, tuple[float, ...]]:
        """The points of each quantity that it varies over."""
        return {name: points for name in AXES if (points := getattr(self, name)) is not None}

    @model_validator(mode="after")
    def _has_its_points(self) -> Self:
        axes, torques = self.axes, np.atleast_1d(self.at_torque or 0.0)
        speeds = (0.0,) if self.at_speed is None else self.at_speed
        if not 1 <= len(axes) <= MOST_AXES:
            raise InputError(
                f"variation.frequency: given {len(axes)} of {', '.join(AXES)}; allowed are one or two of "
                "them, because the spring varies over these."
            )
        for name, points in {**axes, "at_speed": speeds}.items():
            if any(np.diff((-1e-9, *points)) <= 0.0):
                raise InputError(
                    f"variation.{name}: given {list(points)}; allowed are ascending numbers from 0, because "
                    "values between are interpolated."
                )
        low, high = TEMPERATURES
        if self.temperature and not low <= self.temperature[0] <= self.temperature[-1] <= high:
            raise InputError(
                f"variation.temperature: given {list(self.temperature)} K; allowed are {low:g} K to "
                f"{high:g} K, because it is that of rubber or steel."
            )
        shape = tuple(len(points) for points in axes.values())
        for name in ("stiffness", "loss_factor", "damping"):
            values = getattr(self, name)
            if values is None:
                continue
            least = 1e-6 if name == "stiffness" else 0.0
            # None if its rows differ.
            lengths = {len(row) if isinstance(row, tuple) else 0 for row in values}
            table = (len(values), *(lengths - {0})) if len(lengths) == 1 else None
            if table != shape or np.min(values) < least:
                raise InputError(
                    f"variation.{name}: given {list(values)} at {' x '.join(map(str, shape))} points; "
                    f"allowed is one of {least:g} or more at each, because it is that of a passive spring."
                )
        for name, axis in (
            ("at_torque", "torque"),
            ("at_speed", "torque"),
            ("at_temperature", "temperature"),
        ):
            if getattr(self, name) is not None and axis not in axes:
                raise InputError(
                    f"variation.{name}: given without {axis}; allowed are both, because the spring does not "
                    f"vary over the {axis}."
                )
        check_one_each("variation.at_torque", torques.size, len(speeds), "speeds")
        return self

    def of(self, stiffness: float, loss_factor: float = 0.0, damping: float = 0.0) -> "VaryingPart":
        """Return the law of a spring and damper by their constant values [SI].

        Raises
        ------
        InputError
            If mean torque or temperature are needed and not given.
        """
        for name in ("torque", "temperature"):
            if name in self.axes and getattr(self, f"at_{name}") is None:
                raise InputError(
                    f"variation.at_{name}: missing; allowed is the {name} of the spring, because its "
                    f"stiffness varies over the {name}."
                )
        if self.damping is not None and not damping:
            raise InputError(
                "variation.damping: given for a part without viscous damping; allowed are both, because it "
                "stands over the constant one."
            )
        return VaryingPart(self, stiffness, loss_factor, damping)


AXES = ("frequency", "speed", "torque", "temperature", "amplitude")
# So many in one table.
MOST_AXES = 2


@dataclass(frozen=True)
class VaryingPart:
    """A spring k (1 + i loss_factor) and dashpot that vary: the law is that of the pair.

    Its amplitudes at ascending speeds are known once a forced response has found them.
    """

    variation: Variation
    stiffness: float
    loss_factor: float
    damping: float
    amplitudes: tuple[Array, Array] | None = None

    @property
    def over_amplitude(self) -> bool:
        """Whether it depends on the amplitude of vibration."""
        return self.variation.amplitude is not None

    def at_amplitude(self, speeds: Array, amplitudes: Array) -> "VaryingPart":
        """Return the law for amplitudes at speeds."""
        return replace(self, amplitudes=(speeds, amplitudes))

    def constants(self, w: Array, speed: Array) -> tuple[Array, ...]:
        """Return stiffness, loss factor and damping at frequencies and speeds (m,) [rad/s].

        At complex frequencies they are those of the real part.
        """
        course, w = self.variation, np.real(w)
        weights = [
            np.array(
                [np.interp(self._at(name, w, speed), points, hat) for hat in np.eye(len(points))]
            )
            for name, points in course.axes.items()
        ]

        def values(table: Table | None, constant: float) -> Array:
            known = np.full(w.size, constant)
            if table is not None:
                known = np.multiply.outer(np.array(table, dtype=np.float64), np.ones(w.size))
                for over in weights:
                    known = np.einsum("i...m,im->...m", known, over)
            return known

        return (
            self.stiffness * values(course.stiffness, 1.0),
            values(course.loss_factor, self.loss_factor),
            self.damping * values(course.damping, 1.0),
        )

    def added(self, w: Array, speed: Array) -> ComplexArray:
        """Return its complex stiffness beyond k (1 + i loss_factor) + i w damping."""
        stiffness, loss, damping = self.constants(w, speed)
        springs = stiffness * (1.0 + 1j * loss) - self.stiffness * (1.0 + 1j * self.loss_factor)
        return np.asarray(springs + 1j * w * (damping - self.damping))

    def _at(self, axis: str, w: Array, speed: Array) -> Array:
        course = self.variation
        if axis == "frequency":
            return w / (2.0 * np.pi)
        if axis == "torque":
            speeds = (0.0,) if course.at_speed is None else course.at_speed
            return np.asarray(np.interp(speed, speeds, np.atleast_1d(course.at_torque or 0.0)))
        if axis == "temperature":
            return np.full(w.size, course.at_temperature)
        if axis == "amplitude":
            if self.amplitudes is None:
                raise InputError(
                    "variation.amplitude: given where no amplitude is known; allowed are forced vibrations "
                    "of a chain, its loads and power, because only they repeat the calculation with the "
                    "amplitude that it reaches."
                )
            return np.asarray(np.interp(speed, *self.amplitudes))
        return speed


def varied(
    variation: Variation | None, stiffness: float, loss_factor: float = 0.0, damping: float = 0.0
) -> tuple[float, float, float, VaryingPart | None]:
    """Return stiffness, loss factor and damping of a spring, and the law by which they vary, if they do.

    One that depends on nothing but a mean torque and a temperature that are given has their constant values.
    """
    if variation is None:
        return stiffness, loss_factor, damping, None
    law = variation.of(stiffness, loss_factor, damping)
    if variation.at_speed is None and not variation.axes.keys() - {"torque", "temperature"}:
        stiffness, loss_factor, damping = np.ravel(law.constants(np.zeros(1), np.zeros(1))).tolist()
        return stiffness, loss_factor, damping, None
    return stiffness, loss_factor, damping, law
