"""The pressure over a whole cycle by the cycle model, from heat, peak or mean pressure."""

import math
from dataclasses import dataclass, replace
from typing import Any, Literal, get_args

import numpy as np

from crankbase.checks.arrays import FloatArray
from crankbase.checks.choices import check_choice
from crankbase.checks.scalars import is_number, whole_number
from crankbase.drawing.diagram_style import BLUE, new_axes
from crankbase.drawing.legends import write_title
from crankbase.errors import InputError
from crankbase.library_types import Axes, DataFrame
from crankbase.summaries import summarized
from crankbase.tables.frames import table
from dynamics.cycle import even_angles
from dynamics.gas.cycle_values import GasCycle, assumption_remarks, name_of_field
from dynamics.gas.cylinder_volume import CylinderVolume, Position, cylinder_volume
from dynamics.gas.pressure import GasPressure, gas_pressure
from dynamics.gas.sampled_cycle import (
    allowed_heat,
    checked_peak,
    cycle_samples,
    format_mpa,
    heat_for_mean_pressure,
    heat_for_peak,
    motored_pressure,
    mpa_rounded_down,
    mpa_rounded_up,
    no_work_error,
)
from dynamics.plots.quantities import MEGA

SAMPLES_PER_TURN = 1440
FEWEST_PER_TURN = 360
# Steps that the combustion must take at least: a shorter one is a jump between samples.
LEAST_STEPS = 8
# [deg] Where a start or a duration of combustion is looked for when it is solved.
EARLIEST_START, LATEST_START = -60.0, 45.0
LONGEST_DURATION = 150.0
SEARCH_PLACES = 43

Solved = Literal["combustion_start_deg", "combustion_duration_deg"]


@summarized(
    "mean_effective_pressure [Pa]",
    "compression_pressure [Pa]",
    "pressure.peak_pressure [Pa]",
    "work [J]",
    "heat [J]",
)
@dataclass(frozen=True, eq=False)
class GasCycleResult:
    """A calculated cycle.

    Parameters
    ----------
    pressure : GasPressure
        Absolute pressure over the cycle; its remarks state what was solved and assumed.
    cycle : GasCycle
        The parameters, including those that were solved.
    volume : CylinderVolume
        The volume over the piston.
    heat : float
        Heat released in one cycle, less that lost to the walls [J].
    work : float
        Indicated work of one cycle, gas exchange included [J], from the samples of `pressure`.
    mean_effective_pressure : float
        Indicated mean effective pressure, gas exchange included [Pa].
    compression_pressure : float
        Pressure without combustion at the piston's highest position [Pa].
    """

    pressure: GasPressure
    cycle: GasCycle
    volume: CylinderVolume
    heat: float
    work: float
    mean_effective_pressure: float
    compression_pressure: float

    def plot(
        self,
        axes: Axes | None = None,
        *,
        show: Literal["indicator diagram", "pressure"] = "indicator diagram",
    ) -> Axes:
        """Draw the indicator diagram, or the pressure over the crank angle.

        Parameters
        ----------
        axes : matplotlib.axes.Axes, optional
            Where to draw; new axes by default.
        show : {"indicator diagram", "pressure"}, optional
            Pressure over volume, or over the crank angle.

        Returns
        -------
        matplotlib.axes.Axes

        Raises
        ------
        InputError
            If the plot is unknown.
        """
        check_choice(
            "show",
            show,
            ("indicator diagram", "pressure"),
            "pressure is known over volume and angle",
        )
        if show == "pressure":
            return self.pressure.plot(axes)
        axes = new_axes(axes)
        angles_deg = np.append(self.pressure.angles_deg, self.pressure.angles_deg[0])
        pressure = np.append(self.pressure.pressure, self.pressure.pressure[0])
        axes.plot(
            1e3 * self.volume.at(angle_deg=angles_deg), MEGA * pressure, color=BLUE, linewidth=1.4
        )
        axes.set_xlim(left=0.0)
        axes.set_ylim(bottom=0.0)
        axes.set_xlabel("volume [dm$^3$]")
        axes.set_ylabel("absolute pressure [MPa]")
        write_title(axes, f"Indicator diagram, mean {MEGA * self.mean_effective_pressure:.4g} MPa")
        return axes

    def to_pandas(self) -> DataFrame:
        """Return crank angle, volume and pressure, a row for each sample.

        Returns
        -------
        pandas.DataFrame
            Units of the columns in ``attrs["units"]``.

        Raises
        ------
        MissingLibraryError
            If pandas is not installed.
        """
        return table(
            {
                "crank_angle": (self.pressure.angles_deg, "deg"),
                "volume": (self.volume.at(angle_deg=self.pressure.angles_deg), "m^3"),
                "pressure": (self.pressure.pressure, "Pa"),
            }
        )


def gas_cycle(
    cycle: GasCycle,
    position: Position,
    area: float,
    *,
    heat: float | None = None,
    peak_pressure: float | None = None,
    mean_effective_pressure: float | None = None,
    solve_for: Solved = "combustion_start_deg",
    samples: int | None = None,
) -> GasCycleResult:
    """Calculate the pressure over a cycle.

    Parameters
    ----------
    cycle : GasCycle
        Parameters of the cycle, as from `usual_gas_cycle`.
    position : callable
        Position of the piston along the cylinder axis from any origin, growing away from the
        shaft [m], for an array of crank angles [rad] from the nominal firing top. Any mechanism
        is allowed: its dead centers are found.
    area : float
        Piston area [m^2].
    heat : float, optional
        Heat released in one cycle, less that lost to the walls [J]; 0 is a motored engine.
    peak_pressure : float, optional
        Highest absolute pressure [Pa].
    mean_effective_pressure : float, optional
        Indicated mean effective pressure, gas exchange included [Pa]. With `peak_pressure` the
        parameter named in `solve_for` is found too.
    solve_for : str, optional
        "combustion_start_deg" or "combustion_duration_deg", when both pressures are given.
    samples : int, optional
        Even samples over the cycle, 360 a revolution or more; 1440 by default.

    Returns
    -------
    GasCycleResult
        Pressure and the values found. Peak and work are those of the samples, so they meet
        their targets to round-off in every sum over them; another sampling changes them by some
        1e-5 and 1e-8 of their value.

    Raises
    ------
    InputError
        If no target or one too many is given, a target cannot be reached (the message states the
        reachable range), or the samples are too few for the combustion.

    Notes
    -----
    Closed part by the first law with one ratio of heat capacities, see `pressure_rise_per_heat`.
    From exhaust opening to the bottom the pressure passes to that of the exhaust, over the overlap to
    that of the intake, each along 3 t^2 - 2 t^3, and stays there until the intake closes. As the pressure
    is linear in the heat, heat from peak or mean pressure needs no search.

    Examples
    --------
    >>> from dynamics.gas.cycle_values import usual_gas_cycle
    >>> def position(angle):
    ...     return 0.07 * np.cos(angle) + np.sqrt(0.25**2 - (0.07 * np.sin(angle)) ** 2)
    >>> found = gas_cycle(usual_gas_cycle(15.0), position, 0.0133, peak_pressure=14e6)
    >>> round(found.pressure.peak_pressure / 1e6, 9)
    14.0
    """
    volume = cylinder_volume(position, area, cycle.compression_ratio)
    turns = cycle.strokes // 2
    count = SAMPLES_PER_TURN * turns
    if samples is not None:
        why = "steps above 1 deg miss the peak"
        count = whole_number("samples", samples, FEWEST_PER_TURN * turns, why)
    angles_deg = even_angles(cycle.cycle_deg, count)
    if heat is not None and not (peak_pressure is None and mean_effective_pressure is None):
        raise InputError(
            "heat: given together with peak_pressure or mean_effective_pressure; allowed is one of "
            "them, or both pressures, because either sets the heat."
        )
    remarks: list[str] = []
    if peak_pressure is not None and mean_effective_pressure is not None:
        given = cycle
        cycle = _solved_combustion(
            cycle, volume, angles_deg, peak_pressure, mean_effective_pressure, solve_for
        )
        remarks.append(
            f"Solved: {name_of_field(solve_for)} {getattr(cycle, solve_for):.4g} deg in place of "
            f"{getattr(given, solve_for):.4g} deg."
        )
    _check_resolved(cycle, count)
    state = cycle_samples(cycle, volume, angles_deg)
    if heat is not None:
        released = allowed_heat(state, heat)
    elif mean_effective_pressure is not None:
        released = heat_for_mean_pressure(state, mean_effective_pressure)
    elif peak_pressure is not None:
        released = heat_for_peak(state, peak_pressure)
    else:
        raise InputError(
            "heat: given neither it nor peak_pressure nor mean_effective_pressure; allowed is one "
            "of them, or both pressures, because they set the load."
        )
    if heat is None:
        remarks.append(f"Solved: heat {released / 1e3:.4g} kJ per cycle.")
    work = state.work(released)
    return GasCycleResult(
        pressure=gas_pressure(
            state.pressure(released),
            cycle.strokes,
            source="cycle model",
            remarks=(*remarks, *assumption_remarks(cycle)),
            angles_deg=angles_deg,
        ),
        cycle=cycle,
        volume=volume,
        heat=released,
        work=work,
        mean_effective_pressure=work / volume.swept,
        compression_pressure=float(motored_pressure(cycle, volume, volume.top_angle_deg)),
    )


def _shortest_duration(cycle: GasCycle, samples: int) -> float:
    """Return the shortest combustion that the samples resolve [deg]."""
    return LEAST_STEPS * cycle.cycle_deg / samples


def _check_resolved(cycle: GasCycle, samples: int) -> None:
    shortest = _shortest_duration(cycle, samples)
    if cycle.combustion_duration_deg < shortest * (1.0 - 1e-9):
        raise InputError(
            f"combustion_duration_deg: given {cycle.combustion_duration_deg:.4g} deg; allowed is "
            f"{shortest:.4g} deg or more with {samples} samples, because a shorter one "
            "falls between them."
        )


def _solved_combustion(
    cycle: GasCycle,
    volume: CylinderVolume,
    angles_deg: FloatArray,
    peak: float,
    mean_pressure: float,
    name: Solved,
) -> GasCycle:
    """Return the cycle whose start or duration of combustion gives both pressures."""
    check_choice("solve_for", name, get_args(Solved), "these move the peak at a given work")
    motored = cycle_samples(cycle, volume, angles_deg)
    peak = checked_peak(peak, motored.peak(0.0))
    lowest = motored.mean_pressure(0.0)
    if not is_number(mean_pressure) or mean_pressure <= lowest:
        raise InputError(
            f"mean_effective_pressure: given {format_mpa(mean_pressure)}; allowed is more than "
            f"{format_mpa(lowest)}, because that is left without heat."
        )

    assumed = tuple(other for other in cycle.assumed if other != name)

    def changed(value: float) -> GasCycle:
        changes: dict[str, Any] = {name: value}
        return replace(cycle, assumed=assumed, **changes)

    def peak_at(value: float) -> float:
        state = cycle_samples(changed(value), volume, angles_deg)
        if state.work_per_heat <= 0.0:
            return math.inf
        return state.peak(state.heat_for_mean_pressure(mean_pressure))

    places = _search_angles(cycle, angles_deg.size, name)
    peaks = np.array([peak_at(value) for value in places])
    # Later or slower combustion lowers the peak, down to that of compression or of a second hump
    # that a very late one makes; what comes after the lowest is left aside.
    peaks, places = peaks[: np.argmin(peaks) + 1], places[: np.argmin(peaks) + 1]
    reached, places = peaks[np.isfinite(peaks)], places[np.isfinite(peaks)]
    if reached.size == 0:
        raise no_work_error(mean_pressure)
    below = np.flatnonzero((reached[:-1] >= peak) & (reached[1:] <= peak))
    if below.size == 0:
        raise InputError(
            f"peak_pressure: given {format_mpa(peak)}; allowed are {mpa_rounded_up(np.min(reached))} to "
            f"{mpa_rounded_down(np.max(reached))}, because with a mean effective pressure of "
            f"{format_mpa(mean_pressure)} a {name} from {places[0]:.4g} to "
            f"{places[-1]:.4g} deg gives no others."
        )
    from scipy.optimize import brentq  # here: loading it takes a quarter second

    first = int(below[0])
    found = brentq(
        lambda value: peak_at(value) - peak, places[first], places[first + 1], xtol=1e-15
    )
    return changed(float(found))


def _search_angles(cycle: GasCycle, samples: int, name: Solved) -> FloatArray:
    """Return the angles at which to search for the start or the duration of the combustion [deg]."""
    if name == "combustion_start_deg":
        given = cycle.combustion_start_deg
        low = max(EARLIEST_START, cycle.intake_closes_deg)
        high = min(LATEST_START, cycle.exhaust_opens_deg - cycle.combustion_duration_deg)
        return np.linspace(min(low, given), max(high, given), SEARCH_PLACES, dtype=np.float64)
    high = min(LONGEST_DURATION, cycle.exhaust_opens_deg - cycle.combustion_start_deg)
    return np.linspace(_shortest_duration(cycle, samples), high, SEARCH_PLACES, dtype=np.float64)
