"""The equations of a rotating chain as a state over time, for an integrator."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import Any, Literal, get_args

import numpy as np

from crankbase.checks.arrays import FloatArray
from crankbase.checks.choices import check_choice
from dynamics.transient.turning_chain import TurningChain

IntegrationMethod = Literal["DOP853", "Radau"]
# Relative tolerance of the integration; absolute ones are this share of the sizes of the states.
TOLERANCE = 1e-9
WORKS = 3
# The first step, in radians of the highest natural frequency.
FIRST_STEP = 0.1


@dataclass(frozen=True, eq=False)
class TurningState:
    """Columns of a state array (c, 2 q + 4) of c copies of a chain, relative to uniform rotation.

    They are twist, its speed, works of gas, load and dampers, and the integral over time of the
    shaft's part of the twist.

    Parameters
    ----------
    chain : TurningChain
    frame : float
        Speed of the uniform rotation that twists are counted from [rad/s].
    holds : bool
        Whether dampers to ground turn at that speed, or at the current mean speed.
    load : callable
        Shaft speeds (c,) [rad/s] and time [s] to the braking moments (c,) [N m].
    typical_speed : float
        Of the shaft, for the scale of torques and motions [rad/s].
    """

    chain: TurningChain
    frame: float
    holds: bool
    load: Callable[[FloatArray, float], FloatArray]
    typical_speed: float

    @property
    def size(self) -> int:
        """Number of columns."""
        return 2 * self.chain.even.size + WORKS + 1

    @cached_property
    def sizes(self) -> FloatArray:
        """Scale of each column, (2 q + 4,)."""
        chain = self.chain
        rigid = chain.system.system.rigid.shape[1]
        lowest = float(chain.system.system.natural[rigid])
        torque = chain.torque_size(self.typical_speed)
        twist = torque / float(np.max(np.diag(chain.stiffness)))
        count = chain.even.size
        return np.concatenate(
            (
                np.full(count, twist),
                np.full(count, twist * lowest),
                np.full(WORKS, torque),
                [twist / lowest],
            )
        )

    def slope(self, time: float, states: FloatArray) -> FloatArray:
        """Return the derivative by time of states (c, 2 q + 4)."""
        chain, count = self.chain, self.chain.even.size
        twist, vibration = states[:, :count], states[:, count : 2 * count]
        speeds = vibration + self.frame * chain.even
        mean = speeds @ chain.momentum
        reference = np.full(mean.shape, self.frame) if self.holds else mean
        angles = np.full(mean.shape, self.frame * time)
        springs, dampers, gas, inertia = chain.torques(twist, speeds, angles, reference)
        load = -self.load(mean, time)[:, np.newaxis] * chain.load
        found = np.empty_like(states)
        found[:, :count] = vibration
        found[:, count : 2 * count] = chain.accelerations(springs + dampers + gas + load, inertia)
        for place, torques in enumerate((gas, load, dampers), start=2 * count):
            found[:, place] = np.sum(torques * speeds, axis=1)
        found[:, -1] = twist @ chain.momentum
        return found

    def integrate(
        self,
        states: FloatArray,
        span: tuple[float, float],
        method: IntegrationMethod,
        evaluated: Callable[[float], None],
        **options: Any,
    ) -> Any:
        """Integrate states (c, 2 q + 4) over a span of time [s] and return what `solve_ivp` does.

        At each evaluation `evaluated` is called with the time.
        """
        from scipy.integrate import solve_ivp

        shape = states.shape
        # Left to itself, the integrator tries a first step that is far too long for even turning.
        first = FIRST_STEP / float(self.chain.system.system.natural[-1])

        def flat(time: float, values: FloatArray) -> FloatArray:
            evaluated(time)
            return self.slope(time, values.reshape(shape)).reshape(-1)

        return solve_ivp(
            flat,
            span,
            states.reshape(-1),
            method=method,
            first_step=min(first, span[1] - span[0]),
            rtol=TOLERANCE,
            atol=TOLERANCE * np.tile(self.sizes, len(states)),
            **options,
        )


def check_method(method: str) -> None:
    """Refuse an unknown method of integration.

    Raises
    ------
    InputError
    """
    why = "the equations are smooth and may be stiff"
    check_choice("method", method, get_args(IntegrationMethod), why)
