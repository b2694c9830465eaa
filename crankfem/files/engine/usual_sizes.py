"""Sizes of an engine far outside of practice: each is a warning, never an error."""

import math
from collections import Counter
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace

from crankbase.errors import InputError
from crankbase.model import GD2_OF_INERTIA, gd2_name
from crankbase.quantity import PER_MINUTE, RPM, UNITS, format_number, percent
from crankbase.sentences import amount, listed
from crankfem.files.engine.engine_file import EngineFile
from crankfem.files.reading.toml_file import InputWarning
from crankfem.files.sections.crank_throws import PLAIN, Throws
from dynamics.excitation.pressure_map import EnginePower
from dynamics.gas.pressure import ATMOSPHERE
from fem.material import STEEL
from geometry.any_throw import dimensioned
from geometry.throw import CrankThrow
from regression.law.throw_law import DIVISORS, FILLETS, RANGES, REAL, axial_law
from regression.law.throw_law import PLAIN as PLAIN_RANGES

LAW, SHIPPED, M53, PRACTICE = (
    "range of the law's training throws",
    "range of the shipped engines",
    "range of IACS UR M53",
    "usual practice",
)


@dataclass(frozen=True)
class UsualRange:
    """Smallest and largest usual value of a ratio, how it is written, and who has these values.

    `meaning` has braces for the value with its unit. A value beyond the range by the factor `margin` gets
    a warning. The ratio goes with the value to the `power`. `slips` are what else a value may be, by the
    factor that would make it right.
    """

    low: float
    high: float
    meaning: str
    unit: str = "times"
    basis: str = SHIPPED
    margin: float = 2.0
    power: float = 1.0
    slips: tuple[tuple[float, str], ...] = ()

    def warning(self, field: str, text: str, value: float) -> Iterator[InputWarning]:
        """Give the warning of a value far outside of the range; none about any other."""
        if self.low / self.margin <= value <= self.high * self.margin:
            return
        shown = self.meaning.format(self._written(value, digits=3))
        usual = f"usual is {self._written(self.low, self.high)} ({self.basis})"
        yield InputWarning(field, f"{text}, which {shown}; {usual}")

    def _written(self, *values: float, digits: int = 6) -> str:
        """Write values of the ratio with its unit behind the last one."""
        if self.unit in UNITS:
            unit, size = UNITS[self.unit]
            return listed([size * value for value in values], unit, digits, " to ", shown=self.unit)
        return f"{' to '.join(format_number(value, digits) for value in values)} {self.unit}"

    def warning_of(
        self, field: str, value: float, unit: str, ratio: float
    ) -> Iterator[InputWarning]:
        """Give the warning of a quantity in SI units, with the slip that one factor explains."""
        for warning in self.warning(field, f"given {amount(value, unit, 5)}", ratio):
            slips = dict(self.slips)
            if unit.endswith("/rad"):
                slips |= {math.degrees(1.0): "per degree", math.radians(1.0): "per degree"}
            if unit == "rad/s":
                slips |= dict.fromkeys((RPM, PER_MINUTE), "rad/s and 1/min are mixed up")
            if unit == "kg m^2":
                # Either may be in the file: both are read as the inertia.
                name = field.rpartition(".")[2]
                mixed = f"{name} and {gd2_name(name)}, its GD2, are mixed up"
                slips |= {1.0 / GD2_OF_INERTIA: mixed, GD2_OF_INERTIA: mixed}
            slips |= {1e3: "a unit's prefix", 1e-3: "a unit's prefix"}
            suiting = (
                f"; perhaps {slip}: {amount(value * factor, unit, 3)} would suit"
                for factor, slip in slips.items()
                if self.low <= ratio * factor**self.power <= self.high
            )
            yield warning.with_hint(next(suiting, ""))


# Of the shipped engines, rounded outwards to two digits.
PITCH = UsualRange(1.1, 1.8, "is {} the bore for each cylinder of a bank", margin=1.1)
JOURNAL = UsualRange(0.63, 1.3, "is {} the bore", margin=1.5)
STROKE = UsualRange(0.89, 4.1, "is {} the bore")
ROD_LENGTH = UsualRange(2.0, 5.0, "is {} the crank radius", margin=1.5)
PISTON_MASS = UsualRange(0.94, 6.2, "is {} of swept volume", "kg/dm^3")
ROD_MASS = UsualRange(0.98, 5.5, "is {} of swept volume", "kg/dm^3")
PISTON_SPEED = UsualRange(5.5, 14.0, "gives a mean piston speed of {}", "m/s")
HIGHEST_PISTON_SPEED = UsualRange(5.6, 16.0, "gives a mean piston speed of {}", "m/s")
INDICATED = UsualRange(1.0, 2.4, "gives a mean indicated pressure of {}", "MPa")
# Range and margin are less than a factor of two, that of GD2 in the radius of gyration.
FLYWHEEL = UsualRange(1.4, 2.4, "gives a radius of gyration of {} the bore", margin=1.15, power=0.5)
THRUST = UsualRange(2.2, 3.7, "is {} of the main journal's diameter", "MN/m per mm", margin=5.0)
# A ratio of a throw may be beyond the range of the law by this factor.
THROW_MARGIN = 1.25
FREE_END = UsualRange(
    0.41,
    1.3,
    "is {} that of a steel disk of two main journals' diameter and half of it thick",
    margin=1.25,
)
# In these a diameter taken for a radius, or half of an angle for all of it, is outside.
FILLET = UsualRange(
    0.047,
    0.067,
    "is {} main_journal_diameter",
    margin=1.35,
    slips=((0.5, "the diameter"), (2.0, "half of the radius")),
)
WEIGHT_ANGLE = UsualRange(
    80.0,
    150.0,
    "is {}",
    "deg",
    margin=1.05,
    slips=((2.0, "half of the angle"), (0.5, "twice the angle")),
)
# Of the gas exchange: share of the stroke behind the closing of the intake, 35 deg after the bottom, in
# two-stroke engines 65 deg; exponent of compression; least compression ratio of a diesel engine, and the
# intake pressure from which an engine is boosted.
CAUGHT = {4: 0.91, 2: 0.71}
EXPONENT = 1.35
DIESEL, BOOSTED = 12.0, 1.2 * ATMOSPHERE
# Burning all air gives the highest mean pressure; boosted diesel engines leave half of it.
LEAN = UsualRange(
    4.0,
    9.5,
    "gives a mean indicated pressure of {} that of the air caught",
    basis=PRACTICE,
    margin=1.0,
)
RICH = replace(LEAN, low=0.5, high=14.0)
RISE = UsualRange(1.0, 2.0, "makes combustion raise the pressure {}", basis=PRACTICE, margin=1.0)
ATMOSPHERIC = UsualRange(0.8, 6.0, "is {} the atmosphere", basis=PRACTICE, margin=1.1)
EXHAUST = UsualRange(0.75, 1.4, "is {} intake_pressure", basis=PRACTICE, margin=1.1)
OIL_HOLE = UsualRange(0.0, 0.2, "is {} its journal's diameter", basis=M53, margin=THROW_MARGIN)

# Fillets over the main journal's diameter, in the middle of their usual range.
USUAL_FILLET = 0.055
# What sharp corners add to the axial compliance of the shipped engines' throws, by the law.
SHARP = "5 to 14 %"

# Fields of a throw and its parts to the ratio whose range the law's training throws have.
OF_THROW = {
    **{name: name for name in REAL},
    **dict.fromkeys(("fillet_radius", *FILLETS), FILLETS[0]),
    "main_journal_bore": "main_journal_bore",
    "pin_bore": "pin_bore",
}
OF_WEB = {"thickness": "web_thickness", "width": "web_width"}
OF_PIN = {"crank_radius": "crank_radius", "diameter": "pin_diameter", "length": "pin_length"}


def throw_warnings(throws: Throws) -> Iterator[InputWarning]:
    """Name the dimensions of throws that are far out of proportion to their journals.

    Parameters
    ----------
    throws : mapping
        Name to throw; "throw" is that of a plain file.
    """
    for name, throw in dimensioned(throws).items():
        section = name if name == PLAIN else f"throws.{name}"
        yield from _sharp_corners(section, throw)
        yield from _out_of_proportion(section, throw)[0]
        for path, part, _ in _parts(section, throw)[:3]:
            if (weight := getattr(part, "counterweight", None)) is not None:
                yield from WEIGHT_ANGLE.warning_of(
                    f"{path}.counterweight.angle", weight.angle, "rad", math.degrees(weight.angle)
                )
        for hole in throw.parts.drillings:
            yield from OIL_HOLE.warning(
                f"{section}.oil_holes[{hole.number - 1}].diameter",
                f"given {amount(2.0 * hole.radius, 'm')}",
                hole.radius / hole.journal_radius,
            )


def _sharp_corners(section: str, throw: CrankThrow) -> Iterator[InputWarning]:
    """Tell of fillets that are left out, and what that does to the axial compliance."""
    fields = throw.model_fields_set
    if "fillet_radius" in fields or fields.issuperset(FILLETS):
        return
    left_out = next(
        (other for fillet, other in (FILLETS, FILLETS[::-1]) if fillet in fields), "fillet_radius"
    )
    usual = USUAL_FILLET * throw.main_journal_diameter
    try:
        more = axial_law(throw).pinned / axial_law(throw.changed(fillet_radius=usual)).pinned - 1.0
        much = f"{percent(more, 2)} % above that with {amount(usual, 'm', 3)}, by the law"
    except InputError:
        much = f"{SHARP} above that with their fillets in throws of the shipped engines, by the law"
    yield InputWarning(
        f"{section}.{left_out}",
        f"not given, so corners are taken as sharp: e_n is {much}; usual is "
        f"{PLAIN_RANGES['fillet_radius'][0]:g} to {PLAIN_RANGES['fillet_radius'][1]:g} times "
        "main_journal_diameter; write 0 mm for sharp corners on purpose",
    )


def _parts(section: str, throw: CrankThrow) -> list[tuple[str, object, Mapping[str, str]]]:
    """Return the throw and its parts, the throw and its webs first, each with its path and its ratios."""
    return [
        (section, throw, OF_THROW),
        (f"{section}.left_web", throw.left_web, OF_WEB),
        (f"{section}.right_web", throw.right_web, OF_WEB),
        *(
            (f"{section}.further_pins[{place}]", pin, OF_PIN)
            for place, pin in enumerate(throw.further_pins)
        ),
    ]


def _out_of_proportion(section: str, throw: CrankThrow) -> tuple[list[InputWarning], bool]:
    """Name the sizes far out of proportion, or the main journal's where another one would suit them all.

    Also return whether it is the main journal's.
    """
    sizes = [
        (f"{path}.{field}", value, ratio)
        for path, part, known in _parts(section, throw)
        for field, ratio in known.items()
        if (value := getattr(part, field, None))
    ]
    remarks: list[InputWarning] = []
    journal, low, high = throw.main_journal_diameter, 0.0, math.inf
    for field, value, ratio in sizes:
        by = DIVISORS.get(ratio, "main_journal_diameter")
        usual = UsualRange(*RANGES[ratio], f"is {{}} {by}", basis=LAW, margin=THROW_MARGIN)
        if ratio in FILLETS:
            usual = FILLET
        if by == "main_journal_diameter":
            low = max(low, value / (usual.high * usual.margin))
            high = min(high, value * usual.margin / usual.low if usual.low > 0.0 else math.inf)
        remarks += usual.warning_of(field, value, "m", value / getattr(throw, by))
    wrong_journal = len(remarks) > 1 and low <= high and not low <= journal <= high
    if wrong_journal:
        suiting = " to ".join(amount(end, "m", 3) for end in (low, high))
        remarks = [
            InputWarning(
                f"{section}.main_journal_diameter",
                f"given {amount(journal, 'm')}, with which {len(remarks)} other dimensions of the throw are "
                f"out of proportion; all of them suit {suiting} ({LAW})",
            )
        ]
    return remarks, wrong_journal


def size_warnings(file: EngineFile) -> Iterator[InputWarning]:
    """Name the sizes of an engine that are far outside of practice, its throws included."""
    yield from throw_warnings(file.named_throws)
    engine, throw, bore = file.engine, file.crank_throws[0], file.engine.bore

    def warn(
        field: str, value: float, unit: str, usual: UsualRange, ratio: float
    ) -> Iterator[InputWarning]:
        return usual.warning_of(field, value, unit, ratio)

    journal, rod, pitch = throw.main_journal_diameter, file.rod.length, throw.length
    # A journal that is wrong against the throw is not told again against other parts.
    wrong_journal = any(
        _out_of_proportion(name, each)[1] for name, each in dimensioned(file.named_throws).items()
    )
    if file.thrust_bearing is not None and not wrong_journal:
        stiffness = file.thrust_bearing.stiffness
        yield from warn(
            "thrust_bearing.stiffness", stiffness, "N/m", THRUST, stiffness / journal / 1e9
        )
    yield from warn("rod.length", rod, "m", ROD_LENGTH, rod / throw.crank_radius)
    if engine.driven_by:  # one frame carries cylinders of very different bores and pressures
        return
    yield from warn("engine.stroke", engine.stroke, "m", STROKE, engine.stroke / bore)
    if not wrong_journal:
        yield from warn("throw.main_journal_diameter", journal, "m", JOURNAL, journal / bore)
    # Cylinders of one bank stand on the first throw one behind the other.
    banks = file.engine.bank_angles or (0.0,) * file.engine.cylinders
    first = [round(bank, 6) for bank, throw in zip(banks, file.throws, strict=True) if throw == 0]
    yield from PITCH.warning(
        "throw",
        f"{amount(pitch, 'm', 5)} from one main bearing to the next",
        pitch / bore / max(Counter(first).values()),
    )
    swept = 0.25 * math.pi * bore**2 * engine.stroke * 1e3  # [dm^3]
    for field, mass, usual in (
        ("piston.mass", file.piston.mass, PISTON_MASS),
        ("rod.mass", file.rod.mass, ROD_MASS),
    ):
        yield from warn(field, mass, "kg", usual, mass / swept)
    for field, speed, usual in (
        ("engine.rated_speed", engine.rated_speed, PISTON_SPEED),
        ("engine.highest_speed", engine.highest_speed, HIGHEST_PISTON_SPEED),
    ):
        yield from warn(field, speed, "rad/s", usual, engine.mean_piston_speed(speed))
    if file.power is not None:
        mean = file.power.mean_indicated_pressure / 1e6
        yield from INDICATED.warning("gas", "the pressure over the cycle", mean)
        yield from _gas_exchange(file, file.power)
    if file.flywheel is not None:
        inertia = file.flywheel.inertia
        gyration = math.sqrt(inertia / file.flywheel.mass)
        yield from warn("flywheel.inertia", inertia, "kg m^2", FLYWHEEL, gyration / bore)
    if file.free_end is not None and not wrong_journal:
        inertia = file.free_end.inertia
        disk = 0.25 * math.pi * STEEL.density * journal**5
        yield from warn("free_end.inertia", inertia, "kg m^2", FREE_END, inertia / disk)


def _gas_exchange(file: EngineFile, power: EnginePower) -> Iterator[InputWarning]:
    """Compare given pressures of intake and exhaust with the mean pressure, and each other.

    So much mean pressure needs so much air, and the peak is above the compression by so much; a pressure
    above ambient is an atmosphere lower than the absolute one.
    """
    gas = file.gas
    if gas is None:
        return
    ratio, caught = gas.compression_ratio, CAUGHT[file.engine.strokes]
    compression = (1.0 + caught * (ratio - 1.0)) ** EXPONENT
    points = () if file.load is None else file.load.points
    full = (gas.intake_pressure, power.mean_indicated_pressure, gas.peak_pressure)
    parts = [("gas.", *full)] + [
        (
            f"load.points[{place}].",
            point.intake_pressure,
            point.mean_effective_pressure,
            point.peak_pressure,
        )
        for place, point in enumerate(points)
    ]
    for part, pressure, mean, peak in parts:
        if pressure is None:
            continue
        name, lean = f"{part}intake_pressure", pressure >= BOOSTED and ratio >= DIESEL
        yield from _absolute(LEAN if lean else RICH, name, pressure, mean / (caught * pressure))
        yield from _absolute(ATMOSPHERIC, name, pressure, pressure / ATMOSPHERE)
        if peak is not None and ratio >= DIESEL:
            rise = (peak + ATMOSPHERE) / (pressure * compression)
            yield from _absolute(RISE, name, pressure, rise)
    if (exhaust := gas.exhaust_pressure) is not None:
        name = "gas.exhaust_pressure"
        yield from _absolute(ATMOSPHERIC, name, exhaust, exhaust / ATMOSPHERE)
        if gas.intake_pressure is not None:
            yield from _absolute(EXHAUST, name, exhaust, exhaust / gas.intake_pressure)


def _absolute(
    usual: UsualRange, field: str, pressure: float, ratio: float
) -> Iterator[InputWarning]:
    """Give the warning of an absolute pressure [Pa] with what it would be if it were above ambient."""
    absolute = amount(pressure + ATMOSPHERE, "Pa", 3)
    for warning in usual.warning(field, f"given {amount(pressure, 'Pa', 5)}", ratio):
        yield warning.with_hint(f"; perhaps the pressure above ambient, {absolute} absolute")
