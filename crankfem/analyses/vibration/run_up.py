"""An engine's torsional vibration while its speed rises through all resonances."""

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Annotated, Any

import numpy as np

from crankbase.array_checks import Array
from crankbase.errors import InputError
from crankbase.frames import Axes, table_of
from crankbase.results import Internal, Part, Quantity, Result, Speed, result
from crankbase.sentences import kept
from crankbase.table import SI, Column, OutputUnits, Table
from crankbase.written_quantity import parse_quantity
from crankfem.analyses.shaft.chains import magnifier_damping
from crankfem.analyses.vibration.run import EngineVibration
from dynamics.transient.motions import Envelope, TransientMotion, axis_names, transient_motion
from dynamics.transient.propagator import SpeedCurve

SHORTEST, LONGEST = 0.1, 600.0  # s


@result("element", "largest", "at")
class SpringTorque(Result):
    """Amplitude of the torque in a spring while the speed rises."""

    element: str
    largest: Annotated[float, Quantity("N m")]
    at: Speed
    steady: Annotated[float, Quantity("N m", "largest at constant speeds, of those passed")]


@result("duration [s]", "largest [N m]", "steady [N m]", "worst")
class RunUp(Result):
    """A run-up from the lowest speed calculated to the highest running speed.

    Attributes
    ----------
    motion : TransientMotion
        Of the torsional chain; shorter if it was interrupted.
    envelope : Envelope
        Amplitudes over each working cycle, half of the range.
    largest : (e,) array
        Largest of these amplitudes of the torque in each spring [N m].
    steady : (e,) array
        Largest amplitude at constant speeds, of those passed [N m].
    """

    motion: Internal[TransientMotion]
    duration: Annotated[float, Quantity("s", "requested")]
    envelope: Internal[Envelope]
    largest: Internal[Array]
    steady: Internal[Array]

    @property
    def complete(self) -> Part[bool]:
        """Whether it was not interrupted."""
        return self.motion.complete

    @property
    def lowest(self) -> Annotated[float, Quantity("rad/s", exported="1/min", key="from_rpm")]:
        """Speed at the start [rad/s]."""
        return float(self.motion.shaft_speed[0])

    @property
    def highest(self) -> Annotated[float, Quantity("rad/s", exported="1/min", key="to_rpm")]:
        """Speed at the end [rad/s]."""
        return float(self.motion.shaft_speed[-1])

    @property
    def notes(self) -> Part[tuple[str, ...]]:
        """Remarks of the time integration."""
        return tuple(self.motion.notes)

    @property
    def springs(self) -> Annotated[tuple[SpringTorque, ...], Quantity(key="elements")]:
        """The torque in each spring."""
        places = np.argmax(self.envelope.torque, axis=0)
        columns = (self.largest, self.envelope.speed[places], self.steady)
        return tuple(map(SpringTorque, self.elements, *(column.tolist() for column in columns)))

    @property
    def worst(self) -> int:
        """Index of the spring with the largest torque, from 0."""
        return int(np.argmax(self.largest))

    @property
    def elements(self) -> list[str]:
        """Names of the springs, as used by `plot`."""
        return axis_names(self.motion.system.chain, 0, len(self.largest))[1]

    def plot(self, axes: Axes | None = None, element: int | str | None = None) -> Axes:
        """Draw the torque in a spring over the time; see `TransientMotion.plot`.

        Parameters
        ----------
        element : int or str, optional
            By number from 0 or name; the one with the largest torque by default.

        Raises
        ------
        InputError
            If there is no such element.
        """
        return self.motion.plot(axes, self.worst if element is None else element, quantity="torque")

    def to_pandas(self) -> Any:
        """Return a row for each spring: its largest amplitude of torque, its speed, and the steady one.

        Units are in ``frame.attrs["units"]``.
        """
        return table_of(self.springs)

    def parts(self, units: OutputUnits = SI) -> Iterator[Table | str]:
        """Return the largest torques, and remarks."""
        low, high = (units.of("1/min").fixed(speed, 0) for speed in (self.lowest, self.highest))
        cut = "" if self.complete else ", interrupted"
        yield Table.of_records(
            f"Run-up from {low} to {high} {units.of('1/min').name} in {self.duration:g} s{cut}: "
            "amplitude of the torque in the springs",
            self.springs,
            (Column("element", words=True), "element"),
            (Column("largest", "kN m"), "largest"),
            (Column("at", "1/min", decimals=0), "at"),
            (Column("at constant speeds", "kN m"), "steady"),
            weight=lambda spring: spring.largest,
            main=True,
        )
        yield from (units.written(f"Note: {kept(note)}") for note in self.notes)


def parse_duration(text: str) -> float:
    """Return the duration of --run-up [s].

    Raises
    ------
    InputError
        If it is not a time, or out of range.
    """
    duration = parse_quantity(text, "s", "--run-up")
    if not SHORTEST <= duration <= LONGEST:
        raise InputError(
            f"--run-up: given {text!r}; allowed is {SHORTEST:g} s to {LONGEST:g} s, because engines take "
            "that long from idling to full speed."
        )
    return duration


def run_up(
    run: EngineVibration, duration: float, progress: Callable[[float], None] | None = None
) -> RunUp:
    """Integrate the torsional vibration of an engine during a uniform run-up.

    Parameters
    ----------
    duration : float
        From the lowest speed calculated to the highest running speed [s].
    progress : callable, optional
        Called with the share done.

    Returns
    -------
    RunUp
        The finished part, if it is interrupted.

    Raises
    ------
    InputError
        If there is no gas pressure, or a step of the calculation is refused.
    """
    forced = run.forced_torsional
    if forced is None:
        raise InputError(
            "run_up: given an engine without gas pressure; allowed is one with it, because a run-up shows "
            "what the cylinders excite."
        )
    low, high = float(forced.response.speeds[0]), run.engine_file.engine.highest_speed
    added, _ = magnifier_damping(run.engine_file, forced.engine_chain)
    assert forced.response.chain is not None
    motion = transient_motion(
        forced.response.chain,
        forced.response.excitation,
        SpeedCurve.ramp(low, high, duration=duration),
        modal_damping=added,
        progress=progress,
    )
    passed = forced.response.speeds <= motion.shaft_speed[-1]
    envelope = motion.envelope()
    return RunUp(
        motion=motion,
        duration=duration,
        envelope=envelope,
        largest=np.max(envelope.torque, axis=0),
        steady=np.max(forced.loads.elastic.synthesis.amplitude[passed], axis=0),
    )


def picture_run_up(path: Path, run: EngineVibration, run_up: RunUp) -> None:
    """Draw the torque in the spring with the largest one, and its amplitude at constant speeds."""
    from crankfem.analyses.vibration.plots import plot_transient

    forced = run.forced_torsional
    assert forced is not None
    elastic = forced.loads.elastic
    plot_transient(
        path,
        run_up.motion,
        run_up.worst,
        steady=(elastic.speeds, elastic.synthesis.amplitude[:, run_up.worst]),
        title=f"{run.engine_file.engine.name}, run-up in {run_up.duration:g} s",
    )
