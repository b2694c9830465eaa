"""The parameters of the cycle model, with usual values as defaults."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, fields
from itertools import pairwise

import numpy as np

from crankbase.array_checks import nonnegative_number, positive_number, refuse_radians_between
from crankbase.errors import InputError
from crankbase.summaries import summarized
from dynamics.cycle import checked_strokes, cycle_degrees

# [Pa] What an exhaust into the open has at least: the atmosphere and some flow resistance.
LEAST_EXHAUST = 1.05e5
# [deg] Below these the blow-down or the combustion would be a jump.
SHORTEST_BLOW_DOWN = 5.0
# [deg] Bottom dead center after the firing top.
BOTTOM = 180.0


@summarized(
    "strokes",
    "compression_ratio",
    "intake_pressure [Pa]",
    "exhaust_pressure [Pa]",
    "heat_capacity_ratio",
    "combustion_start_deg [deg]",
    "combustion_duration_deg [deg]",
    "assumed",
)
@dataclass(frozen=True)
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


def assumption_remarks(cycle: GasCycle) -> tuple[str, ...]:
    """Return one sentence for each assumed parameter: its value and why."""
    names = [field.name for field in fields(cycle) if field.name in cycle.assumed]
    return tuple(
        f"Assumed: {name_of_field(name)} {_format_parameter(name, getattr(cycle, name))}, because "
        f"{USUAL_VALUES[name].reason}."
        for name in names
    )


def _format_parameter(name: str, value: float) -> str:
    if name.endswith("_pressure"):
        return f"{value / 1e6:.4g} MPa"
    if name.startswith(("heat_", "wiebe_", "compression_")):
        return f"{value:g}"
    return f"{value:.6g} deg"


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
            f"{name}: given {_format_parameter(name, value)}; allowed is more than "
            f"{_format_parameter(name, above)} and "
            f"less than {_format_parameter(name, below)}, because {reason}."
        )
