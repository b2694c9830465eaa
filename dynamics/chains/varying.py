"""Springs whose stiffness and damping vary with the frequency of vibration or the speed of the shaft."""

from dataclasses import dataclass
from typing import Protocol, Self

import numpy as np
from pydantic import model_validator

from crankbase.array_checks import ComplexArray, FloatArray
from crankbase.errors import InputError
from crankbase.model import InputModel, quantity_field


class StiffnessLaw(Protocol):
    """A complex stiffness that varies, as that of a coupling or a journal bearing."""

    def added(self, w: FloatArray, speed: FloatArray) -> ComplexArray:
        """Return what it is beyond the constant one [N m/rad or N/m], (m,).

        Parameters
        ----------
        w, speed : ndarray of shape (m,)
            Angular frequency of vibration and speed of the shaft [rad/s].
        """
        ...


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

    row: FloatArray
    law: StiffnessLaw
    constant: complex = 0j

    def added(self, w: FloatArray, speed: FloatArray) -> ComplexArray:
        """Return its stiffness beyond that in the matrices, at frequencies and speeds (m,) [rad/s]."""
        return self.law.added(w, speed) - self.constant


class Variation(InputModel):
    """How a spring and its damper vary over the frequency of vibration or the speed of the shaft.

    Between its points they are linear, beyond them as at the first or last.
    """

    section = "variation"

    frequency: tuple[float, ...] | None = quantity_field(
        "ascending frequencies of vibration", "Hz", default=None
    )
    speed: tuple[float, ...] | None = quantity_field(
        "ascending speeds of the crankshaft, in place of frequencies", "rad/s", default=None
    )
    stiffness: tuple[float, ...] = quantity_field(
        "stiffness at each, over the constant one, which natural frequencies are calculated with",
        "",
    )
    loss_factor: tuple[float, ...] | None = quantity_field(
        "loss factor at each, in place of the constant one", "", default=None
    )
    damping: tuple[float, ...] | None = quantity_field(
        "viscous damping at each, over the constant one", "", default=None
    )

    @model_validator(mode="after")
    def _has_its_points(self) -> Self:
        points = self.frequency if self.speed is None else self.speed
        if points is None or (self.frequency and self.speed):
            raise InputError(
                "variation.frequency: given both it and speed, or neither; allowed is one of the two, "
                "because the spring varies over it."
            )
        if any(np.diff((-1e-9, *points)) <= 0.0):
            raise InputError(
                f"variation.{'frequency' if self.speed is None else 'speed'}: given {list(points)}; allowed "
                "are ascending numbers from 0, because values between are interpolated."
            )
        for name in ("stiffness", "loss_factor", "damping"):
            values = getattr(self, name)
            least = 1e-6 if name == "stiffness" else 0.0
            if values is not None and (len(values) != len(points) or min(values) < least):
                raise InputError(
                    f"variation.{name}: given {list(values)} at {len(points)} points; allowed is one of "
                    f"{least:g} or more at each, because it is that of a passive spring."
                )
        return self

    def of(self, stiffness: float, loss_factor: float = 0.0, damping: float = 0.0) -> "VaryingPart":
        """Return the law of a spring and damper by their constant values [SI]."""
        return VaryingPart(self, stiffness, loss_factor, damping)


@dataclass(frozen=True)
class VaryingPart:
    """A spring k (1 + i loss_factor) and dashpot that vary: the law is that of the pair."""

    variation: Variation
    stiffness: float
    loss_factor: float
    damping: float

    def added(self, w: FloatArray, speed: FloatArray) -> ComplexArray:
        """Return its complex stiffness beyond k (1 + i loss_factor) + i w damping."""
        course, over_speed = self.variation, self.variation.speed
        points = course.frequency if over_speed is None else over_speed
        at = w / (2.0 * np.pi) if over_speed is None else speed

        def value(values: tuple[float, ...] | None, constant: float) -> FloatArray | float:
            return constant if values is None else np.interp(at, points or (), values)

        loss = value(course.loss_factor, self.loss_factor)
        springs = value(course.stiffness, 1.0) * (1.0 + 1j * loss) - 1.0 - 1j * self.loss_factor
        viscous = 1j * w * self.damping * (value(course.damping, 1.0) - 1.0)
        return np.asarray(self.stiffness * springs + viscous)
