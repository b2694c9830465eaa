"""The elastic hinge of a file: guides, speed fluctuation, other operating points, tables and diagrams."""

import math
import re
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Annotated, Any, Literal

import numpy as np

from crankbase.array_checks import Array, ComplexArray
from crankbase.choices import check_choice
from crankbase.diagrams import (
    BLUE,
    COLORS,
    GRAY,
    GREEN,
    ORANGE,
    figure,
    legend_inside,
    make_folder,
    new_axes,
    write_title,
)
from crankbase.errors import InputError
from crankbase.frames import Axes, table
from crankbase.quantity import RPM, format_quantity, percent
from crankbase.results import Flat, Internal, Number, Part, Quantity, Result, Speed, result
from crankbase.sentences import amount, kept, listed
from crankbase.table import SI, Column, Main, OutputUnit, OutputUnits, Table
from crankfem.analyses.record import AssumedInput, assumed_values
from crankfem.satellites.hinge.crosshead import KINEMATICS, Kinematics
from crankfem.satellites.hinge.file import HingeFile
from crankfem.satellites.hinge.moment import HingeMoment
from crankfem.satellites.hinge.profile import ComparedGuides, HingeProfile, ProfileCheck
from crankfem.satellites.hinge.spring import GasSpring, Length
from crankfem.satellites.hinge.turning import (
    BestPressure,
    SteadyHingeTurn,
    best_pressure,
    flywheel_for,
    moment_residuals,
    simulate_hinge,
    steady_hinge_turn,
)
from dynamics.turning.speed_over_angle import SpeedOverAngle

Shown = Literal["moment", "gas force", "speed", "guides"]
SHOWN: tuple[Shown, ...] = ("moment", "gas force", "speed", "guides")
DASHES = ("-", "--", ":", "-.")


@result("pressure", "fluctuation", "flywheel")
class ChosenPressure(Result):
    """What the guides do at another operating point with the pressure that the file chooses for it.

    Parameters
    ----------
    fluctuation : float or None
        None if the crank does not complete a revolution.
    moment_residual, largest_residual : float
        As in `BestPressure`.
    flywheel : float
        Inertia that reaches the compared fluctuation.
    """

    pressure: Annotated[float, Quantity("Pa")]
    fluctuation: Number | None
    moment_residual: Number
    largest_residual: Number
    flywheel: Annotated[float, Quantity("kg m^2")]


@result("speed", "best.pressure", "flywheel", "flywheel_with_hinge")
class OtherSpeed(Result):
    """Another operating point with the same guides.

    Parameters
    ----------
    point : HingeMoment
        Of that running point.
    flywheel, flywheel_with_hinge : float
        Inertia that reaches the compared fluctuation without the hinge, and with it at its best
        pressure.
    """

    point: Annotated[HingeMoment, Quantity(key="hinge_moment")]
    best: Flat[BestPressure]
    flywheel: Annotated[float, Quantity("kg m^2", key="flywheel_without_hinge")]
    flywheel_with_hinge: Annotated[float, Quantity("kg m^2")]
    chosen: Annotated[ChosenPressure | None, Quantity(left_out=True)] = None

    @property
    def shown_pressure(self) -> float:
        """The file's, else the best [Pa]."""
        return self.best.pressure if self.chosen is None else self.chosen.pressure

    @property
    def speed(self) -> Speed:
        """Of the crank."""
        return self.point.speed


@result("smallest_radius", "largest_radius")
class GuideSurface(Result):
    """Least and largest distance of the guides' surface from the axis."""

    smallest_radius: Length
    largest_radius: Length


@result("roller_radius", "surface")
class RolledGuides(Result):
    """Guides with rollers; the surface is None where `HingeRun.surface` is."""

    guides: Flat[HingeProfile]
    roller_radius: Length
    surface: GuideSurface | None


@result("turn.mean_speed", "turn.fluctuation", "reason")
class TurnWithoutHinge(Result):
    """A revolution without the hinge, and why the crank does not come round at the mean speed if so."""

    turn: Flat[SpeedOverAngle]
    reason: str | None

    @property
    def comes_round_at_mean_speed(self) -> Part[bool]:
        """Whether the crank does."""
        return self.reason is None


@result(
    "with_hinge.fluctuation", "without.turn.fluctuation", "flywheel.flywheel", "remaining_share"
)
class FreeTurns(Result):
    """Revolutions under the constant load.

    Parameters
    ----------
    with_hinge, without : SpeedOverAngle, TurnWithoutHinge
        Integrated from the top dead center: with the hinge at the mean speed, without it from the
        same speed at the top.
    flywheel : SteadyHingeTurn
        Without the hinge, with the inertia that reaches the compared fluctuation.
    """

    with_hinge: SpeedOverAngle
    without: TurnWithoutHinge
    flywheel: SteadyHingeTurn

    @property
    def remaining_share(self) -> Number:
        """Fluctuation with the hinge relative to that without it."""
        return self.with_hinge.fluctuation / self.without.turn.fluctuation


@result("engine", "moment.load", "moment.moment [N m]", "turning.flywheel.flywheel", "others")
class HingeRun(Result):
    """All results for a hinge file.

    Parameters
    ----------
    moment : HingeMoment
        For which the guides are designed, with the requested kinematics.
    point : HingeMoment
        The same operating point with exact kinematics, for the free rotation of the crank.
    compared : tuple of ComparedGuides
        Those of other springs.
    deviations : dict
        Largest difference of M_h from that of exact kinematics, relative to the largest M_h, for each of the
        other kinematics.
    """

    file: Internal[HingeFile]
    point: Internal[HingeMoment]
    profile: Internal[HingeProfile]
    moment: Annotated[HingeMoment, Quantity(key="hinge_moment")]
    turning: FreeTurns
    others: Annotated[tuple[OtherSpeed, ...], Quantity(key="other_speeds")]
    compared: tuple[ComparedGuides, ...]
    deviations: Annotated[dict[Kinematics, float], Quantity("1", key="kinematics_deviation")]

    @property
    def engine(self) -> Part[str]:
        """Its name."""
        return self.file.name

    @property
    def speed(self) -> Speed:
        """For which the guides are designed."""
        return self.point.speed

    @property
    def kinematics(self) -> Part[Kinematics]:
        """For which the guides are designed."""
        return self.moment.kinematics

    @property
    def spring(self) -> Part[GasSpring]:
        """Of the guides."""
        return self.profile.spring

    @property
    def rolled(self) -> Annotated[RolledGuides, Quantity(key="profile")]:
        """The guides with their surface."""
        surface = None
        if self.surface is not None:
            distance = np.abs(self.surface)
            surface = GuideSurface(float(distance.min()), float(distance.max()))
        return RolledGuides(self.profile, self.profile.roller_radius, surface)

    @property
    def assumed(self) -> Part[tuple[AssumedInput, ...]]:
        """Values of the file that nobody gave."""
        return assumed_values(self.file.records)

    @property
    def surface(self) -> ComplexArray | None:
        """The surface for rollers of the file's radius, x + i y [m]; see `HingeProfile.guide`.

        None if the rollers have no radius, so that it is their path, or if the surface would have a
        cusp, which the checks of the guides report.
        """
        try:
            return self.profile.guide() if self.profile.roller_radius > 0.0 else None
        except InputError:
            return None

    def plot(self, axes: Axes | None = None, *, show: Shown = "moment") -> Axes:
        """Draw one diagram of the hinge.

        Parameters
        ----------
        show : str
            "moment" for constant speed, or "gas force", at all operating points; "speed" over a revolution;
            "guides": the rollers' path, for the largest of several springs, else for the file's.

        Raises
        ------
        InputError
            If `show` is unknown.
        """
        check_choice("show", show, SHOWN, "these are diagrams of a hinge")
        if show == "guides":
            return self.plot_guides(axes)
        axes = new_axes(axes)
        points = [self.moment, *(other.point for other in self.others)]
        if show == "moment":
            given = [
                (
                    self.profile.moment_at(other.shown_pressure, angles_deg=other.point.angles_deg),
                    other.shown_pressure,
                )
                for other in self.others
            ]
            draw_moments(axes, points, [None, *given])
        elif show == "gas force":
            draw_gas_force(axes, points)
        else:
            draw_speeds(axes, self.turning, from_speed=self.point.speed)
        return axes

    @property
    def drawn(self) -> tuple[ComparedGuides, ...]:
        """The compared guides; without a comparison those of the file's spring."""
        spring, profile = self.spring, self.profile
        own = ComparedGuides(spring.height, spring.pressure, profile.start_radius, profile)
        return self.compared or (own,)

    @property
    def spring_sizes(self) -> list[tuple[float, float]]:
        """Height of the spring and initial radius of the guides to draw, the largest first [m]."""
        return sorted({(each.height, each.start_radius) for each in self.drawn}, reverse=True)

    def plot_guides(self, axes: Axes | None = None, size: int = 0) -> Axes:
        """Draw the rollers' path for all springs of one of the `spring_sizes`.

        Parameters
        ----------
        size : int, optional
            Number of the size, the largest by default.
        """
        height, start = self.spring_sizes[size]
        compared = [
            each for each in self.drawn if (each.height, each.start_radius) == (height, start)
        ]
        axes = new_axes(axes)
        draw_guides(axes, height, start, compared)
        return axes

    def to_pandas(self) -> Any:
        """Return a table of the other operating points with the same guides.

        Units are in ``frame.attrs["units"]``.
        """
        others = self.others
        return table(
            {
                "speed": ([other.speed for other in others], "rad/s"),
                "best_pressure": ([other.best.pressure for other in others], "Pa"),
                "fluctuation": ([other.best.fluctuation for other in others], "1"),
                "flywheel": ([other.flywheel for other in others], "kg m^2"),
                "flywheel_with_hinge": ([other.flywheel_with_hinge for other in others], "kg m^2"),
            }
        )

    def tables(self, units: OutputUnits = SI) -> Iterator[Table | str]:
        """Return what the console prints: tables and sentences."""
        yield from self._moment_tables(units)
        yield from self._guide_tables(units)
        yield from self._turning_tables(units)
        if self.others:
            yield from self._other_tables(units)
        if self.compared:
            yield from self._compared_tables(units)
        if self.assumed:
            fields = (re.sub(r"\[\d+\]", "", entry.field) for entry in self.assumed)
            yield (
                f"Assumed, not given ({len(self.assumed)} values): {', '.join(dict.fromkeys(fields))}; "
                "the file and --json give the reasons."
            )
        share = self.turning.remaining_share
        yield Main(f"The hinge leaves {share:.2g} of the fluctuation.")

    def _moment_tables(self, units: OutputUnits) -> Iterator[Table | str]:
        moment = self.moment
        yield Table(
            units.written(
                f"{self.engine} at {amount(self.speed, 'rad/s', 4)}: moments on the crank "
                f"({self.kinematics} kinematics)"
            ),
            [
                Column("", words=True),
                Column("", "kN m"),
                Column("at", "deg", decimals=1, missing=""),
            ],
            [
                ["load M_r", moment.load, None],
                ["largest M_h", moment.largest, math.radians(moment.largest_at_deg)],
                ["least M_h", moment.least, math.radians(moment.least_at_deg)],
            ],
        )
        low, high = moment.reduced_inertia
        yield units.written(
            f"Reduced inertia {listed((low, high), 'kg m^2', 4, ' to ')}; the hinge stores and returns "
            f"{amount(moment.energy_swing, 'J', 4, shown='kJ')} per revolution; integral of M_h over a "
            f"revolution {abs(moment.closing_error):.1e} of that of its absolute value."
        )
        deviations = (f"{name} {percent(share, 2)} %" for name, share in self.deviations.items())
        yield (
            "Largest difference of M_h to exact kinematics, by the largest M_h: "
            f"{', '.join(deviations)}."
        )

    def _guide_tables(self, units: OutputUnits) -> Iterator[Table | str]:
        spring, profile, surface = self.spring, self.profile, self.rolled.surface
        length, pressure = units.of("mm"), units.of("MPa")
        values = [
            ("radius, smallest", profile.smallest_radius, length),
            ("radius, largest", profile.largest_radius, length),
        ]
        if surface is not None:
            values += [
                ("surface of the rollers' guides, smallest", surface.smallest_radius, length),
                ("surface of the rollers' guides, largest", surface.largest_radius, length),
            ]
        values += [
            ("compression z, largest", profile.largest_compression, length),
            ("gas pressure, largest", profile.largest_pressure, pressure),
            ("force on a roller, largest", profile.largest_normal_force, units.of("kN")),
            (
                "off the spring's axis",
                math.radians(profile.largest_force_angle_deg),
                units.of("deg"),
            ),
        ]
        yield Table(
            f"Guides for a gas spring of {pressure.with_name(spring.pressure)}, "
            f"{length.with_name(spring.height)} high, n = {spring.exponent:g}",
            [Column("", words=True), Column("value"), Column("unit", words=True)],
            [[name, unit.number(value), unit.name] for name, value, unit in values],
            main=True,
        )

        def unit(check: ProfileCheck) -> OutputUnit:
            return pressure if check.unit == "Pa" else length

        checks = profile.checks
        yield Table.of_columns(
            "Feasibility",
            (
                Column("check", words=True),
                [f"{check.name} [{unit(check).name}]" for check in checks],
            ),
            (
                Column("found"),
                [
                    None if math.isinf(check.value) else unit(check).number(check.value)
                    for check in checks
                ],
            ),
            (Column("limit"), [f"> {unit(check).number(check.limit)}" for check in checks]),
            (
                Column("met", words=True),
                ["yes" if check.met else f"no: {check.reason}" for check in checks],
            ),
            main=True,
        )
        for remark in profile.remarks:
            yield units.written(f"Note: {kept(remark)}")

    def _turning_tables(self, units: OutputUnits) -> Iterator[Table | str]:
        turning = self.turning
        without, wheel = turning.without.turn, turning.flywheel
        yield Table(
            "Crank turning freely under the constant load",
            [
                Column("", words=True),
                Column("mean", "1/min", decimals=2),
                Column("fluctuation (max - min)/mean", digits=3),
            ],
            [
                [name, turn.mean_speed, turn.fluctuation]
                for name, turn in (
                    ("with the hinge", turning.with_hinge),
                    ("without, from the same speed at the top", without),
                    (f"without, flywheel of {_inertia(wheel.flywheel, units)}", wheel),
                )
            ],
            main=True,
        )
        if turning.without.reason is not None:
            yield units.written(f"Note: without hinge and flywheel, {kept(turning.without.reason)}")

    def _other_tables(self, units: OutputUnits) -> Iterator[Table | str]:
        others = self.others
        yield Table.of_columns(
            "The same guides at other running points: start pressure with the smallest fluctuation",
            (Column("", "1/min"), [other.speed for other in others]),
            (Column("M_r", "kN m"), [other.point.load for other in others]),
            (Column("p_0", "MPa"), [other.best.pressure for other in others]),
            (Column("ratio", decimals=3), [other.best.ratio for other in others]),
            (Column("fluctuation", digits=3), [other.best.fluctuation for other in others]),
            (
                Column("M_h lacks", "%", 3, joint=", at most "),
                [(other.best.moment_residual, other.best.largest_residual) for other in others],
            ),
        )
        yield (
            "M_h lacks: difference from the moment for constant speed, relative to it; first by root mean "
            "squares, then by largest values."
        )
        wanted = self.turning.flywheel.fluctuation
        for other in others:
            unchanged = other.best.unchanged
            fate = (
                "the crank does not complete a revolution"
                if unchanged is None
                else f"the fluctuation is {unchanged:.3g}"
            )
            yield (
                f"At {units.of('1/min').with_name(other.speed)} with the pressure unchanged {fate}; a "
                f"fluctuation of {wanted:.3g} takes a flywheel of "
                f"{_inertia(other.flywheel_with_hinge, units)} with the best pressure, "
                f"{_inertia(other.flywheel, units)} without the hinge."
            )
            chosen = other.chosen
            if chosen is None:
                continue
            fate = (
                "the crank does not complete a revolution without a flywheel"
                if chosen.fluctuation is None
                else f"the fluctuation is {chosen.fluctuation:.3g}"
            )
            yield (
                f"At {units.of('1/min').with_name(other.speed)} with the file's pressure of "
                f"{units.of('MPa').with_name(chosen.pressure)} {fate}; M_h lacks "
                f"{percent(chosen.moment_residual, 3)} %, at most {percent(chosen.largest_residual, 3)} %; a "
                f"fluctuation of {wanted:.3g} takes a flywheel of {_inertia(chosen.flywheel, units)}."
            )

    def _compared_tables(self, units: OutputUnits) -> Iterator[Table | str]:
        each = [(spring, spring.guides) for spring in self.compared]
        yield Table.of_columns(
            "Guides by size and pressure: radii, largest pressure, steepest force on a roller",
            (Column("H", "mm"), [spring.height for spring, _ in each]),
            (Column("rho_0", "mm"), [spring.start_radius for spring, _ in each]),
            (Column("p_0", "MPa"), [spring.pressure for spring, _ in each]),
            (
                Column("rho", "mm", joint=" to "),
                [
                    (guides.smallest_radius, guides.largest_radius) if guides else "not feasible"
                    for _, guides in each
                ],
            ),
            (
                Column("p", "MPa", missing=""),
                [guides and guides.largest_pressure for _, guides in each],
            ),
            (
                Column("off axis", "deg", decimals=1, missing=""),
                [guides and math.radians(guides.largest_force_angle_deg) for _, guides in each],
            ),
        )
        for spring in self.compared:
            if spring.refused is not None:
                yield units.written(f"Note: {kept(spring.refused)}")


def _inertia(value: float, units: OutputUnits) -> str:
    unit = units.of("kg m^2")
    return f"{value / unit.size:,.0f} {unit.name}"


def run_hinge(
    file: HingeFile, kinematics: Kinematics = "exact", speed: float | None = None
) -> HingeRun:
    """Calculate a hinge file.

    Parameters
    ----------
    kinematics : str, optional
        Kinematics for the design of the guides.
    speed : float, optional
        The one other operating point to calculate [rad/s]; by default all of the file.

    Raises
    ------
    InputError
        If the guides cannot be made, or there is no operating point of that speed.
    """
    moment = file.moment(kinematics=kinematics)
    point = moment if kinematics == "exact" else file.moment()
    if speed is not None:
        file.point_at("--speed", speed)
    profile = file.profile(moment)
    without = simulate_hinge(point, start_speed=point.speed)
    wanted, reason = file.operation.flywheel_fluctuation, None
    try:
        steady_hinge_turn(point)
    except InputError as error:
        reason = str(error)
    flywheel = steady_hinge_turn(point, flywheel=flywheel_for(point, wanted))
    others = [
        other
        for other in (file.speeds if speed is None else (speed,))
        if not math.isclose(other, file.design_speed, rel_tol=1e-6) or speed is not None
    ]
    largest = float(np.max(np.abs(point.moment)))
    return HingeRun(
        file=file,
        point=point,
        profile=profile,
        moment=moment,
        turning=FreeTurns(
            simulate_hinge(point, profile), TurnWithoutHinge(without, reason), flywheel
        ),
        others=tuple(_other(file, profile, other) for other in others),
        compared=file.compared(moment),
        deviations={
            name: float(np.max(np.abs(file.moment(kinematics=name).moment - point.moment)))
            / largest
            for name in KINEMATICS
            if name != "exact"
        },
    )


def _other(file: HingeFile, profile: HingeProfile, speed: float) -> OtherSpeed:
    point, wanted = file.moment(speed), file.operation.flywheel_fluctuation
    best = best_pressure(point, profile)
    chosen = None
    if (pressure := file.point_at("speed", speed).pressure) is not None:
        hinge = profile.with_pressure(pressure)
        try:
            fluctuation = steady_hinge_turn(point, hinge).fluctuation
        except InputError:  # the crank does not come round
            fluctuation = None
        flywheel = flywheel_for(point, wanted, hinge)
        chosen = ChosenPressure(pressure, fluctuation, *moment_residuals(point, hinge), flywheel)
    return OtherSpeed(
        point=point,
        best=best,
        flywheel=flywheel_for(point, wanted),
        flywheel_with_hinge=flywheel_for(point, wanted, profile.with_pressure(best.pressure)),
        chosen=chosen,
    )


def draw_gas_force(axes: Axes, points: Sequence[HingeMoment]) -> None:
    """Draw the gas force on the piston at operating points."""
    _draw_points(axes, [(point, point.gas) for point in points])
    write_title(axes, "Gas force on the piston")
    axes.set_ylabel("force [kN]")
    _turn_axis(axes)
    legend_inside(axes)


def draw_moments(
    axes: Axes, points: Sequence[HingeMoment], given: Sequence[tuple[Array, float] | None]
) -> None:
    """Draw the hinge moment for constant speed at operating points, and that of the guides.

    Parameters
    ----------
    given : sequence
        For each point the moment of the guides [N m] at a pressure [Pa]; None where the guides are designed
        for the moment.
    """
    _draw_points(axes, [(point, point.moment) for point in points])
    for place, (point, guides) in enumerate(zip(points, given, strict=True)):
        if guides is not None:
            moment, pressure = guides
            axes.plot(
                point.angles_deg,
                moment / 1e3,
                "--",
                color=COLORS[place % len(COLORS)],
                linewidth=1.2,
                label=f"given at {pressure / 1e6:.3g} MPa",
            )
    write_title(axes, "Hinge moment for constant speed")
    axes.set_ylabel("$M_h$ [kN m]")
    axes.axhline(0.0, color=GRAY, linewidth=0.8)
    _turn_axis(axes)
    legend_inside(axes)


def _draw_points(axes: Axes, curves: Sequence[tuple[HingeMoment, Array]]) -> None:
    """Draw values in thousands over a revolution for each operating point, labeled with its speed."""
    for place, (point, values) in enumerate(curves):
        label = format_quantity(point.speed, "rad/s", 5)
        color = COLORS[place % len(COLORS)]
        axes.plot(point.angles_deg, values / 1e3, color=color, label=label)


def draw_guides(
    axes: Axes, height: float, start: float, compared: Sequence[ComparedGuides]
) -> None:
    """Draw the rollers' path for springs of one height from one initial radius [m], by pressure [Pa]."""
    circle = np.exp(1j * np.linspace(0.0, 2.0 * np.pi, 361)) * start
    axes.plot(circle.real, circle.imag, color=GRAY, linewidth=0.8, label="start radius")
    for place, spring in enumerate(compared):
        label, guides = f"{spring.pressure / 1e6:g} MPa", spring.guides
        color, dash = COLORS[place % len(COLORS)], DASHES[place % len(DASHES)]
        if guides is None:
            axes.plot([], [], dash, color=color, label=f"{label}: not feasible")
            continue
        curve = guides.radius * np.exp(1j * np.radians(guides.angles_deg))
        closed = np.append(curve, curve[0])
        axes.plot(closed.real, closed.imag, dash, color=color, label=label)
    axes.plot([0.0], [0.0], "+", color=GRAY)
    axes.set_aspect("equal")
    write_title(axes, f"H = {height:g} m, $\\rho_0$ = {start:g} m", mathematics=True)
    axes.set_xlabel("$\\rho\\,\\cos\\,\\varphi$ [m]")
    axes.set_ylabel("$\\rho\\,\\sin\\,\\varphi$ [m]")
    axes.set_ylim(-1.15 * start, 1.6 * start)
    axes.legend(frameon=False, fontsize=8, ncols=2, loc="upper center")


def draw_speeds(axes: Axes, turning: FreeTurns, *, from_speed: float) -> None:
    """Draw the speed over a revolution with the hinge, with a flywheel, and without either.

    Parameters
    ----------
    from_speed : float
        At the top dead center [rad/s].
    """
    without, wheel, hinge = turning.without.turn, turning.flywheel, turning.with_hinge
    with_wheel = f"flywheel of {wheel.flywheel:,.0f} kg m$^2$"
    for angles_deg, speed, color, dash, label in (
        (without.angle_deg, without.speed, ORANGE, "-", "without hinge and flywheel"),
        (wheel.angles_deg, wheel.speed, GREEN, "--", with_wheel),
        (hinge.angle_deg, hinge.speed, BLUE, "-", "hinge"),
    ):
        axes.plot(angles_deg, speed * RPM, dash, color=color, label=label)
    axes.set_ylim(0.0, 1.3 * without.highest_speed * RPM)
    axes.set_ylabel("crank speed [1/min]")
    write_title(
        axes, f"Speed over a turn from {format_quantity(from_speed, 'rad/s', 5)} at the top"
    )
    _turn_axis(axes)
    axes.legend(frameon=False, fontsize=9, loc="upper right")


def _turn_axis(axes: Axes) -> None:
    axes.set_xlim(0.0, 360.0)
    axes.set_xticks(np.arange(0.0, 361.0, 60.0))
    axes.set_xlabel("crank angle from the top [deg]")


def hinge_columns(run: HingeRun) -> dict[str, Array]:
    """Return forces, moments, guides and speeds over the revolution, by name with unit."""
    moment, profile = run.moment, run.profile
    surface = run.surface
    guides = {} if surface is None else {"guide_x_m": surface.real, "guide_y_m": surface.imag}
    return {
        "crank_angle_deg": moment.angles_deg,
        "gas_force_N": moment.gas,
        "reduced_inertia_kg_m2": moment.reduced.inertia,
        "inertia_rate_kg_m2_per_rad": moment.reduced.inertia_rate,
        "hinge_moment_N_m": moment.moment,
        "radius_m": profile.radius,
        "slope_m_per_rad": profile.slope,
        "curvature_per_m": profile.curvature,
        "compression_m": profile.compression,
        "pressure_Pa": profile.pressure,
        "spring_force_N": profile.spring_force,
        "normal_force_N": profile.normal_force,
        **guides,
        "speed_with_hinge_rad_per_s": _at(run.turning.with_hinge, np.radians(moment.angles_deg)),
        "speed_without_rad_per_s": _at(run.turning.without.turn, np.radians(moment.angles_deg)),
    }


def _at(turn: SpeedOverAngle, angles: Array) -> Array:
    """Return the speed at angles, by linear interpolation between the steps of the integration."""
    return np.interp(angles, np.radians(turn.angle_deg), turn.speed)


# Files of the diagrams; that of the guides' surface is written where rollers have a radius.
FILES = ("hinge_moment.svg", "hinge_speed.svg", "hinge_guides.svg")
SURFACE = "hinge_surface.svg"


def plot_hinge(folder: Path, run: HingeRun) -> list[Path]:
    """Write all diagrams into a folder, which is created if necessary.

    Raises
    ------
    InputError
        If the folder cannot be made.
    """
    make_folder(folder)
    made = [folder / name for name in FILES]
    with figure(made[0], columns=2, width=9.6, height=4.4) as (left, right):
        run.plot(left, show="gas force")
        run.plot(right, show="moment")
    with figure(made[1]) as axes:
        run.plot(axes, show="speed")
    count = len(run.spring_sizes)
    with figure(made[2], columns=count, width=4.6 * count, height=4.9) as panels:
        for size, panel in enumerate(np.atleast_1d(panels)):
            run.plot_guides(panel, size)
    if run.surface is not None:
        made.append(folder / SURFACE)
        with figure(made[-1], width=6.4, height=6.8) as axes:
            run.profile.plot(axes)
    return made
