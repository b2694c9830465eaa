"""The pressure over a whole cycle by the cycle model, its parameters, and their usual values."""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, fields, replace
from itertools import pairwise
from typing import Any, Literal, get_args

import numpy as np
from numpy.typing import ArrayLike

from crankbase.array_checks import (
    Array,
    finite_vector,
    nonnegative_number,
    positive_number,
    refuse_radians_between,
)
from crankbase.choices import check_choice, is_number, number_within, whole_number
from crankbase.diagrams import BLUE, new_axes, write_title
from crankbase.errors import InputError
from crankbase.frames import Axes, DataFrame, table
from crankbase.sentences import amount, angle, finished, kept, written
from crankbase.summaries import frozen
from dynamics.cycle import checked_strokes, cycle_degrees, even_angles
from dynamics.gas.pressure import (
    HIGHEST_PEAK,
    CylinderVolume,
    GasPressure,
    Position,
    cylinder_volume,
    indicated_work,
    periodic_slope,
)
from dynamics.plots.curves import MEGA

# [Pa] What an exhaust into the open has at least: the atmosphere and some flow resistance.
LEAST_EXHAUST = 1.05e5
# [deg] Below these the blow-down or the combustion would be a jump.
SHORTEST_BLOW_DOWN = 5.0
# [deg] Bottom dead center after the firing top.
BOTTOM = 180.0


@frozen(
    "strokes",
    "compression_ratio",
    "intake_pressure [Pa]",
    "exhaust_pressure [Pa]",
    "heat_capacity_ratio",
    "combustion_start_deg [deg]",
    "combustion_duration_deg [deg]",
    "assumed",
)
class GasCycle:
    """Parameters of the cycle model: compression, Wiebe heat release, expansion, gas exchange.

    All angles are crank angles in degrees from the firing top dead center. `usual_gas_cycle` fills
    in unknown ones.

    Parameters
    ----------
    compression_ratio : float
        Largest over smallest volume, geometric.
    intake_pressure : float
        Absolute pressure in the cylinder at the end of the intake [Pa].
    exhaust_pressure : float
        Absolute pressure in the cylinder during exhaust [Pa].
    heat_capacity_ratio : float
        Ratio of the heat capacities of the gas at constant pressure and volume, one for the cycle.
    combustion_start_deg : float
        Where heat release begins [deg], negative before the top.
    combustion_duration_deg : float
        Crank angle over which it lasts [deg].
    wiebe_shape : float
        Exponent m of the Wiebe law, 0 or more: the rate begins as the m-th power of the angle.
    wiebe_completeness : float
        Share of the heat that the untruncated Wiebe law releases within the duration; the law is
        scaled so that all of the heat is released.
    intake_closes_deg : float
        Where the last valve or port closes and compression begins [deg], negative.
    exhaust_opens_deg : float
        Where the first valve or port opens and expansion ends [deg].
    overlap_begins_deg, overlap_ends_deg : float
        Interval in which the pressure passes from exhaust to intake [deg].

    Raises
    ------
    InputError
        If a value is out of its range, the events are not in order, or one is evidently in
        radians.
    """

    strokes: int
    compression_ratio: float
    intake_pressure: float
    exhaust_pressure: float
    heat_capacity_ratio: float
    combustion_start_deg: float
    combustion_duration_deg: float
    wiebe_shape: float
    wiebe_completeness: float
    intake_closes_deg: float
    exhaust_opens_deg: float
    overlap_begins_deg: float
    overlap_ends_deg: float
    assumed: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        checked_strokes(self.strokes)
        _check_finite("combustion_start_deg", self.combustion_start_deg)
        _check_range("compression_ratio", self.compression_ratio, 1.0, 100.0, "it compresses")
        positive_number("intake_pressure", self.intake_pressure, "Pa", "it is absolute pressure")
        positive_number("exhaust_pressure", self.exhaust_pressure, "Pa", "it is absolute pressure")
        reason = "gases have ratios between these, 5/3 with single atoms"
        _check_range("heat_capacity_ratio", self.heat_capacity_ratio, 1.0, 1.7, reason)
        nonnegative_number(
            "wiebe_shape", self.wiebe_shape, "", "the rate of heat release is finite"
        )
        reason = "it is the share of heat released by the end"
        _check_range("wiebe_completeness", self.wiebe_completeness, 0.5, 1.0, reason)
        positive_number("combustion_duration_deg", self.combustion_duration_deg, "deg", "it lasts")
        self._check_order()

    @property
    def cycle_deg(self) -> float:
        """Length of the cycle in crank angle."""
        return cycle_degrees(self.strokes)

    def _check_order(self) -> None:
        """Refuse events in radians, and events that are not in order over the cycle."""
        opening = BOTTOM - SHORTEST_BLOW_DOWN * (1.0 - 1e-9)
        earliest = -1.5 * BOTTOM if self.strokes == 4 else -BOTTOM
        for name, low, high in (
            ("exhaust_opens_deg", 0.0, BOTTOM),
            ("intake_closes_deg", earliest, 0.0),
            ("overlap_begins_deg", 0.0, self.cycle_deg),
            ("overlap_ends_deg", 0.0, self.cycle_deg),
        ):
            _check_finite(name, getattr(self, name))
            refuse_radians_between(name, getattr(self, name), low, high)
        reason = "the blow-down ends at the bottom dead center and takes its time"
        _check_range("exhaust_opens_deg", self.exhaust_opens_deg, 0.0, opening, reason)
        reason = "the charge is compressed before the top and taken in before that"
        _check_range("intake_closes_deg", self.intake_closes_deg, earliest, 0.0, reason)
        events = (
            ("intake_closes_deg", self.intake_closes_deg),
            ("combustion_start_deg", self.combustion_start_deg),
            ("end of combustion", self.combustion_start_deg + self.combustion_duration_deg),
            ("exhaust_opens_deg", self.exhaust_opens_deg),
        )
        exchange = (
            ("bottom dead center", BOTTOM),
            ("overlap_begins_deg", self.overlap_begins_deg),
            ("overlap_ends_deg", self.overlap_ends_deg),
            ("intake_closes_deg one cycle later", self.intake_closes_deg + self.cycle_deg),
        )
        for chain in (events, exchange):
            for (before, earlier), (after, later) in pairwise(chain):
                # Round-off of a file's angles, which were radians, is no disorder.
                if not earlier <= later + 1e-9:
                    raise InputError(
                        f"{after}: given {later:.6g} deg, with {before} at "
                        f"{earlier:.6g} deg; allowed is a later angle, because closing, "
                        "combustion, opening, overlap and closing follow in this order."
                    )
        if self.overlap_ends_deg - self.overlap_begins_deg < SHORTEST_BLOW_DOWN * (1.0 - 1e-9):
            raise InputError(
                f"overlap_ends_deg: given {self.overlap_ends_deg:.6g} deg after overlap_begins_deg at "
                f"{self.overlap_begins_deg:.6g} deg; allowed is {SHORTEST_BLOW_DOWN:g} deg or "
                "more between them, because the pressure passes over and does not jump."
            )


@dataclass(frozen=True)
class UsualValue:
    """A default value."""

    value: Callable[[int, Mapping[str, float]], float]
    reason: str


def _value_by_strokes(four: float, two: float) -> Callable[[int, Mapping[str, float]], float]:
    return lambda strokes, _: four if strokes == 4 else two


USUAL_VALUES: dict[str, UsualValue] = {
    "intake_pressure": UsualValue(
        _value_by_strokes(2.5e5, 2.5e5),
        "turbocharged diesel engines at rated load have 0.2 to 0.4 MPa in the receiver",
    ),
    "exhaust_pressure": UsualValue(
        lambda _, known: max(0.9 * known["intake_pressure"], LEAST_EXHAUST),
        "a good turbocharger leaves the exhaust about a tenth below the intake, and no engine "
        "exhausts below the atmosphere",
    ),
    "heat_capacity_ratio": UsualValue(
        _value_by_strokes(1.35, 1.35),
        "air has 1.40 cold and 1.34 at 1000 K, lean burnt gas at 2000 K about 1.28; measured "
        "compressions follow 1.33 to 1.37",
    ),
    "combustion_start_deg": UsualValue(
        _value_by_strokes(-6.0, -2.0),
        "diesel fuel injected 10 to 15 deg before the top burns some degrees later, in slow "
        "two-stroke engines about the top",
    ),
    "combustion_duration_deg": UsualValue(
        _value_by_strokes(60.0, 60.0),
        "with the shape 1 this releases half of the heat within 19 deg, as diesel engines do",
    ),
    "wiebe_shape": UsualValue(
        _value_by_strokes(1.0, 1.0),
        "diesel engines have 0.5 to 1.5 as burning by mixing falls slowly, spark ignition about 2",
    ),
    "wiebe_completeness": UsualValue(
        _value_by_strokes(0.999, 0.999), "it is the customary end of the law, with the factor 6.908"
    ),
    "intake_closes_deg": UsualValue(
        _value_by_strokes(-145.0, -115.0),
        "inlet valves close about 35 deg after the bottom; ports are symmetric about it",
    ),
    "exhaust_opens_deg": UsualValue(
        _value_by_strokes(130.0, 115.0),
        "exhaust valves of four-stroke engines open about 50 deg before the bottom, exhaust ports "
        "and valves of two-stroke engines 60 to 70 deg before it",
    ),
    "overlap_begins_deg": UsualValue(
        _value_by_strokes(320.0, 180.0),
        "in a four-stroke engine the valves overlap by some 80 deg about the top, in a two-stroke "
        "engine the fresh charge takes over after the bottom",
    ),
    "overlap_ends_deg": UsualValue(
        lambda strokes, known: 400.0 if strokes == 4 else known["intake_closes_deg"] + 2.0 * BOTTOM,
        "in a four-stroke engine the valves overlap by some 80 deg about the top, and a two-stroke "
        "cylinder is at intake pressure when it closes",
    ),
}


def usual_gas_cycle(compression_ratio: float, strokes: int = 4, **known: float) -> GasCycle:
    """Return the parameters of a cycle; by default those of a turbocharged diesel.

    Parameters
    ----------
    **known : float
        Any other parameters of `GasCycle`: angles in degrees, the rest in SI units.

    Returns
    -------
    GasCycle
        Its `assumed` names the defaults.

    Raises
    ------
    InputError
        If a parameter is unknown, out of its range, or the events are not in order, or in
        radians.

    Notes
    -----
    The defaults, with reasons in `USUAL_VALUES`: intake pressure 0.25 MPa, as turbocharged diesel
    engines at rated load have 0.2 to 0.4 MPa; exhaust pressure nine tenths of it but not below
    0.105 MPa; ratio of heat capacities 1.35, between that of hot air and of burnt gas; combustion
    from 6 deg (two-stroke 2 deg) before the top over 60 deg, with the Wiebe shape 1 and
    completeness 99.9 %, so that half of the heat is released 19 deg after the start; closing 35 deg
    after the bottom (two-stroke 65 deg); exhaust opening 50 deg before the bottom (two-stroke
    65 deg); overlap from 40 deg before to 40 deg after the gas-exchange top (two-stroke: from the
    bottom to the closing).

    Examples
    --------
    >>> cycle = usual_gas_cycle(14.0, intake_pressure=3e5)
    >>> cycle.exhaust_pressure, cycle.assumed[0]
    (270000.0, 'exhaust_pressure')
    """
    checked_strokes(strokes)
    unknown = [name for name in known if name not in USUAL_VALUES]
    if unknown:
        raise InputError(
            f"{unknown[0]}: given {known[unknown[0]]!r}; allowed are {', '.join(USUAL_VALUES)}, "
            "because the cycle model has no other parameters."
        )
    for name, value in known.items():
        _check_finite(name, value)
    values = dict(known)
    assumed = tuple(name for name in USUAL_VALUES if name not in known)
    for name in assumed:
        values[name] = USUAL_VALUES[name].value(strokes, values)
    return GasCycle(
        strokes=int(strokes), compression_ratio=compression_ratio, assumed=assumed, **values
    )


def name_of_field(name: str) -> str:
    """Return the name of a parameter in files and remarks, where its unit is next to the number."""
    return name.removesuffix("_deg")


def name_fields(error: InputError | str) -> str:
    """Return the text of an error of the cycle model with the names that the fields of files have."""
    return kept(str(error)).replace("_deg", "")


def assumption_remarks(cycle: GasCycle) -> tuple[str, ...]:
    """Return one sentence for each assumed parameter: its value and why."""
    names = [field.name for field in fields(cycle) if field.name in cycle.assumed]
    return tuple(
        finished(
            f"Assumed: {name_of_field(name)} {_format_parameter(name, getattr(cycle, name))}, because "
            f"{USUAL_VALUES[name].reason}."
        )
        for name in names
    )


def _format_parameter(name: str, value: float) -> str:
    if name.endswith("_pressure"):
        return amount(value, "Pa", 4)
    if name.startswith(("heat_", "wiebe_", "compression_")):
        return f"{value:g}"
    return angle(value)


def _check_finite(name: str, value: object) -> None:
    raw = np.asarray(value)
    if raw.ndim != 0 or raw.dtype.kind not in "iuf" or not np.isfinite(raw):
        raise InputError(
            f"{name}: given {value!r}; allowed are finite numbers "
            f"{'of degrees' if name.endswith('_deg') else 'in SI units'}, because the cycle is "
            "calculated from it."
        )


def _check_range(name: str, value: float, above: float, below: float, reason: str) -> None:
    """Refuse what is not a number strictly between two limits."""
    _check_finite(name, value)
    if not above < value < below:
        raise InputError(
            written(
                f"{name}: given {_format_parameter(name, value)}; allowed is more than "
                f"{_format_parameter(name, above)} and less than {_format_parameter(name, below)}, because "
                f"{reason}."
            )
        )


# Peak pressure over that without combustion, usual for diesel engines at rated load: 1.4 to 1.8.
USUAL_PRESSURE_RISE = 1.6
# The combustion is integrated over r, where r^4 is the share of its duration: the rate of heat
# release, which may begin as any power of the share, begins smoothly over r. Parts besides those
# between the angles asked for, and Gauss points in each, bring the integral to 1e-12 for
# shapes up to 10.
ROOT_POWER = 4
PARTS = 96
GAUSS_POINTS = 6


@dataclass(frozen=True, eq=False)
class CycleSamples:
    """A cycle at even crank angles: pressure = motored + heat * rise.

    Parameters
    ----------
    motored : ndarray of shape (m,)
        Absolute pressure without heat [Pa].
    rise : ndarray of shape (m,)
        Rise of the pressure for one joule of heat [Pa/J], zero where the cylinder is open.
    volume_slope : ndarray of shape (m,)
        Derivative of the volume by the crank angle [m^3/rad].
    swept : float
        Swept volume [m^3].
    """

    motored: Array
    rise: Array
    volume_slope: Array
    swept: float
    strokes: int

    def pressure(self, heat: float) -> Array:
        """Return the pressure [Pa] for a heat [J]."""
        return self.motored + heat * self.rise

    def peak(self, heat: float) -> float:
        """Return the highest pressure [Pa] for a heat [J]."""
        return float(np.max(self.pressure(heat)))

    def work(self, heat: float) -> float:
        """Return the indicated work [J] for a heat [J]."""
        return indicated_work(self.pressure(heat), self.volume_slope, self.strokes)

    def mean_pressure(self, heat: float) -> float:
        """Return the indicated mean effective pressure [Pa] for a heat [J]."""
        return self.work(heat) / self.swept

    @property
    def work_per_heat(self) -> float:
        """Increase of the indicated work per joule of heat [J/J]."""
        return indicated_work(self.rise, self.volume_slope, self.strokes)

    def heat_for_peak(self, peak: float) -> float:
        """Return the heat [J] at which the first sample reaches the peak [Pa]."""
        rising = self.rise > 0.0
        return float(np.min((peak - self.motored[rising]) / self.rise[rising]))

    def heat_for_mean_pressure(self, mean_pressure: float) -> float:
        """Return the heat [J] for an indicated mean effective pressure [Pa]."""
        return (mean_pressure * self.swept - self.work(0.0)) / self.work_per_heat


def cycle_samples(cycle: GasCycle, volume: CylinderVolume, angles_deg: Array) -> CycleSamples:
    """Return the cycle at its samples.

    Parameters
    ----------
    angles_deg : ndarray of shape (m,)
        Even crank angles from zero over the cycle, the closing one left out.
    """
    # 1 where the cylinder is closed, 0 where it is open, between in the blow-down.
    share = 1.0 - _smooth_step(angles_deg, cycle.exhaust_opens_deg, BOTTOM)
    share[angles_deg >= cycle.intake_closes_deg + cycle.cycle_deg] = 1.0
    closed = share > 0.0
    within = np.where(angles_deg > BOTTOM, angles_deg - cycle.cycle_deg, angles_deg)[closed]
    # The pressure of the exhaust, then of the intake, passing over in the overlap.
    passed = _smooth_step(angles_deg, cycle.overlap_begins_deg, cycle.overlap_ends_deg)
    open_pressure = cycle.exhaust_pressure + passed * (
        cycle.intake_pressure - cycle.exhaust_pressure
    )
    motored = open_pressure.copy()
    motored[closed] += share[closed] * (
        motored_pressure(cycle, volume, within) - open_pressure[closed]
    )
    rise = np.zeros(angles_deg.size)
    rise[closed] = share[closed] * pressure_rise_per_heat(cycle, volume, within)
    return CycleSamples(
        motored=motored,
        rise=rise,
        volume_slope=periodic_slope(volume.at(angle_deg=angles_deg), math.radians(cycle.cycle_deg)),
        swept=volume.swept,
        strokes=cycle.strokes,
    )


def _smooth_step(angles: Array, begin: float, end: float) -> Array:
    """Return 3 t^2 - 2 t^3, from 0 at the start to 1 at the end, with zero slope at both."""
    share = np.clip((angles - begin) / (end - begin), 0.0, 1.0)
    return np.asarray(share**2 * (3.0 - 2.0 * share), dtype=np.float64)


def motored_pressure(cycle: GasCycle, volume: CylinderVolume, angle_deg: ArrayLike) -> Array:
    """Return the pressure without combustion, isentropic from the closing of the intake.

    Parameters
    ----------
    angle_deg : array_like of any shape
        Crank angles within the closed part.

    Returns
    -------
    ndarray of the same shape
        p_closing (V_closing / V)^g [Pa].
    """
    ratio = volume.at(angle_deg=cycle.intake_closes_deg) / volume.at(angle_deg=angle_deg)
    return np.asarray(cycle.intake_pressure * ratio**cycle.heat_capacity_ratio, dtype=np.float64)


def pressure_rise_per_heat(cycle: GasCycle, volume: CylinderVolume, angle_deg: ArrayLike) -> Array:
    """Return the pressure rise per joule of heat.

    Parameters
    ----------
    angle_deg : array_like of shape (m,)
        Crank angles within the closed part, in any order.

    Returns
    -------
    ndarray of shape (m,)
        (g - 1) / V(angle)^g times the integral of V^(g - 1) dx from the start of the combustion, x
        the burnt share [Pa/J].

    Notes
    -----
    x = (1 - exp(-a t^(m + 1))) / c with t = (angle - s) / d from 0 to 1 and a = -ln(1 - c): the law of
    I. I. Wiebe (Brennverlauf und Kreisprozess von Verbrennungsmotoren, 1970), which reaches the
    completeness c at the end of the duration d, scaled so that it reaches 1.

    The first law for a gas with constant heat capacities, dQ = d(p V) / (g - 1) + p dV, is
    d(p V^g) = (g - 1) V^(g - 1) dQ, so the pressure is that without combustion plus the heat
    times this rise. The integral is evaluated by Gauss quadrature in parts.
    """
    angles_deg = finite_vector("angle_deg", angle_deg)
    start, duration = cycle.combustion_start_deg, cycle.combustion_duration_deg
    exponent, closing = (
        cycle.heat_capacity_ratio,
        float(volume.at(angle_deg=cycle.intake_closes_deg)),
    )
    # Between roots r of the share t = r^q of the duration; dx = a (m + 1) t^m exp(-a t^(m + 1)) dt / c and
    # dt = q r^(q - 1) dr.
    asked = np.clip((angles_deg - start) / duration, 0.0, 1.0) ** (1.0 / ROOT_POWER)
    ends, place = np.unique(
        np.concatenate([asked, np.linspace(0.0, 1.0, PARTS + 1)]), return_inverse=True
    )
    nodes, weights = np.polynomial.legendre.leggauss(GAUSS_POINTS)
    half = 0.5 * np.diff(ends)[:, np.newaxis]
    root = ends[:-1, np.newaxis] + half * (1.0 + nodes)
    factor = -math.log1p(-cycle.wiebe_completeness)
    power = ROOT_POWER * (cycle.wiebe_shape + 1.0)
    burnt_by_root = (
        factor
        / cycle.wiebe_completeness
        * power
        * root ** (power - 1.0)
        * np.exp(-factor * root**power)
    )
    within = volume.at(angle_deg=start + duration * root**ROOT_POWER) / closing
    parts = (half * (burnt_by_root * within ** (exponent - 1.0))) @ weights
    integrals = np.concatenate([[0.0], np.cumsum(parts)])
    relative = volume.at(angle_deg=angles_deg) / closing
    rise = (exponent - 1.0) / closing * integrals[place[: angles_deg.size]] / relative**exponent
    return np.asarray(rise, dtype=np.float64)


def allowed_heat(state: CycleSamples, heat: float) -> float:
    """Return a heat [J] whose peak is not above that of real engines."""
    nonnegative_number("heat", heat, "J", "combustion releases heat")
    most = state.heat_for_peak(HIGHEST_PEAK)
    peak = f"{format_mpa(HIGHEST_PEAK)}, which no piston engine withstands"
    return number_within("heat", heat, 0.0, most, "J", f"more drives the peak above {peak}")


def heat_for_peak(state: CycleSamples, peak_pressure: float) -> float:
    """Return the heat [J] that gives a peak pressure [Pa]."""
    peak = checked_peak(peak_pressure, state.peak(0.0))
    return max(state.heat_for_peak(peak), 0.0)


class PeakError(InputError):
    """A peak that a cycle does not reach; `allowed` is what it can reach, and why."""

    allowed: str


def _peak_error(peak: float, allowed: str) -> PeakError:
    error = PeakError(f"peak_pressure: given {format_mpa(peak)}; allowed are {allowed}")
    error.allowed = allowed
    return error


def checked_peak(peak: float, lowest: float) -> float:
    """Return a peak [Pa] from the lowest, that of compression alone, to the highest of real engines."""
    # The lowest peak is found to round-off, and it may be what is asked for.
    if not is_number(peak) or not lowest * (1.0 - 1e-12) <= peak <= HIGHEST_PEAK:
        raise _peak_error(
            peak,
            f"{rounded_mpa(lowest, np.ceil)} to {format_mpa(HIGHEST_PEAK)}, because compression alone gives "
            "the lowest and no piston engine withstands more than the highest.",
        )
    return max(float(peak), lowest)


def heat_for_mean_pressure(state: CycleSamples, mean_pressure: float) -> float:
    """Return the heat [J] that gives an indicated mean effective pressure [Pa]."""
    lowest = state.mean_pressure(0.0)
    if state.work_per_heat <= 0.0:
        raise no_work_error(mean_pressure)
    highest = state.mean_pressure(state.heat_for_peak(HIGHEST_PEAK))
    inside = is_number(mean_pressure) and mean_pressure <= highest
    if not inside or mean_pressure < lowest - 1e-12 * abs(lowest):
        raise InputError(
            f"mean_effective_pressure: given {format_mpa(mean_pressure)}; allowed are "
            f"{rounded_mpa(lowest, np.ceil)} to "
            f"{rounded_mpa(highest, np.floor)}, because no heat gives the lowest and the highest "
            "drives the peak to "
            f"{format_mpa(HIGHEST_PEAK)}."
        )
    return max(state.heat_for_mean_pressure(mean_pressure), 0.0)


def no_work_error(mean_pressure: float) -> InputError:
    """Return the error for a combustion whose heat does no work."""
    return InputError(
        f"mean_effective_pressure: given {format_mpa(mean_pressure)}; allowed is what a later combustion "
        "gives, because the heat of this one is all released too early to do work."
    )


def rounded_mpa(pressure: float, to_whole: Callable[[float], float]) -> str:
    """Write a pressure into a text with four digits in MPa, a least one rounded up: it is allowed."""
    if not pressure or not np.isfinite(pressure):
        return format_mpa(pressure)
    step = 10.0 ** (np.floor(np.log10(abs(pressure))) - 3)
    return format_mpa(float(to_whole(pressure / step) * step))


def format_mpa(pressure: float) -> str:
    """Write a pressure into a text, or the given value if it is none."""
    return amount(pressure, "Pa") if is_number(pressure) else repr(pressure)


SAMPLES_PER_TURN = 1440
FEWEST_PER_TURN = 360
# Steps that the combustion must take at least: a shorter one is a jump between samples.
LEAST_STEPS = 8
# [deg] Where a start or a duration of combustion is looked for when it is solved.
EARLIEST_START, LATEST_START = -60.0, 45.0
LONGEST_DURATION = 150.0
SEARCH_PLACES = 43

Solved = Literal["combustion_start_deg", "combustion_duration_deg"]


@frozen(
    "mean_effective_pressure [Pa]",
    "compression_pressure [Pa]",
    "pressure.peak_pressure [Pa]",
    "work [J]",
    "heat [J]",
    eq=False,
)
class GasCycleResult:
    """A calculated cycle.

    Parameters
    ----------
    pressure : GasPressure
        Absolute pressure over the cycle; its remarks state what was solved and assumed.
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
        """Draw the indicator diagram, or the pressure over the crank angle."""
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
        """Return crank angle, volume and pressure, a row for each sample."""
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
    >>> from dynamics.gas.gas_cycle import usual_gas_cycle
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
    solved: list[str] = []
    if peak_pressure is not None and mean_effective_pressure is not None:
        before = cycle
        cycle = _solved_combustion(
            cycle, volume, angles_deg, peak_pressure, mean_effective_pressure, solve_for
        )
        solved.append(
            f"Solved: {name_of_field(solve_for)} {getattr(cycle, solve_for):.4g} deg in place of "
            f"{getattr(before, solve_for):.4g} deg."
        )
    shortest = _shortest_duration(cycle, count)
    if cycle.combustion_duration_deg < shortest * (1.0 - 1e-9):
        raise InputError(
            f"combustion_duration_deg: given {cycle.combustion_duration_deg:.4g} deg; allowed is "
            f"{shortest:.4g} deg or more with {count} samples, because a shorter one "
            "falls between them."
        )
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
        solved.append(f"Solved: heat {amount(released, 'J', 4, shown='kJ')} per cycle.")
    work = state.work(released)
    assumed = assumption_remarks(cycle)
    return GasCycleResult(
        pressure=GasPressure(
            angles_deg,
            state.pressure(released),
            cycle.strokes,
            source="cycle model",
            remarks=(*solved, *assumed),
            assumed=assumed,
            solved=tuple(solved),
        ),
        cycle=cycle,
        volume=volume,
        heat=released,
        work=work,
        mean_effective_pressure=work / volume.swept,
        compression_pressure=float(motored_pressure(cycle, volume, volume.top_angle_deg)),
    )


@dataclass(frozen=True)
class FullLoad:
    """What is known of the cycle of an engine at full load.

    Parameters
    ----------
    known : mapping of str to float
        Further parameters of `GasCycle`; the others are the usual ones.
    peak_pressure : float, optional
        Highest absolute pressure [Pa].
    mean_effective_pressure : float, optional
        Indicated [Pa]; it or the peak is required.
    """

    compression_ratio: float
    known: Mapping[str, float]
    peak_pressure: float | None = None
    mean_effective_pressure: float | None = None

    def parameters(
        self, strokes: int, position: Position, area: float
    ) -> tuple[GasCycle, tuple[str, ...]]:
        """Return the cycle's parameters, and remarks on an intake pressure that suits the peak.

        Position and area are those of one cylinder; all breathe from one receiver.
        """
        cycle = usual_gas_cycle(self.compression_ratio, strokes, **self.known)
        if "intake_pressure" in self.known or self.peak_pressure is None:
            return cycle, ()
        plain = gas_cycle(cycle, position, area, heat=0.0)
        rise = self.peak_pressure / plain.compression_pressure
        intake = cycle.intake_pressure * rise / USUAL_PRESSURE_RISE
        suited = usual_gas_cycle(
            self.compression_ratio, strokes, **(dict(self.known) | {"intake_pressure": intake})
        )
        remark = (
            f"Assumed: intake_pressure {amount(intake, 'Pa', 4)}, so that combustion raises the "
            f"pressure {USUAL_PRESSURE_RISE:g} times, as is usual for diesel engines at rated load."
        )
        return suited, (remark,)


def _shortest_duration(cycle: GasCycle, samples: int) -> float:
    """Return the shortest combustion that the samples resolve [deg]."""
    return LEAST_STEPS * cycle.cycle_deg / samples


def _solved_combustion(
    cycle: GasCycle,
    volume: CylinderVolume,
    angles_deg: Array,
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

    if name == "combustion_start_deg":
        now = cycle.combustion_start_deg
        low = min(max(EARLIEST_START, cycle.intake_closes_deg), now)
        last = cycle.exhaust_opens_deg - cycle.combustion_duration_deg
        high = max(min(LATEST_START, last), now)
    else:
        low = _shortest_duration(cycle, angles_deg.size)
        high = min(LONGEST_DURATION, cycle.exhaust_opens_deg - cycle.combustion_start_deg)
    places = np.linspace(low, high, SEARCH_PLACES, dtype=np.float64)
    peaks = np.array([peak_at(value) for value in places])
    # Later or slower combustion lowers the peak, down to that of compression or of a second hump
    # that a very late one makes; what comes after the lowest is left aside.
    peaks, places = peaks[: np.argmin(peaks) + 1], places[: np.argmin(peaks) + 1]
    reached, places = peaks[np.isfinite(peaks)], places[np.isfinite(peaks)]
    if reached.size == 0:
        raise no_work_error(mean_pressure)
    below = np.flatnonzero((reached[:-1] >= peak) & (reached[1:] <= peak))
    if below.size == 0:
        raise _peak_error(
            peak,
            f"{rounded_mpa(np.min(reached), np.ceil)} to {rounded_mpa(np.max(reached), np.floor)}, because "
            "with a mean effective pressure of "
            f"{format_mpa(mean_pressure)} a {name} from {places[0]:.4g} to "
            f"{places[-1]:.4g} deg gives no others.",
        )
    from scipy.optimize import brentq  # here: loading it takes a quarter second

    first = int(below[0])
    root = brentq(lambda value: peak_at(value) - peak, places[first], places[first + 1], xtol=1e-15)
    return changed(float(root))
