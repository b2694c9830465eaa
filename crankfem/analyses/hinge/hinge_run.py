"""Calculation of an elastic hinge: guides, speed fluctuation, other operating points."""

import math
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from crankbase.array_checks import ComplexArray, FloatArray
from crankbase.choices import check_choice
from crankbase.diagrams import figure, make_folder, new_axes
from crankbase.errors import InputError
from crankbase.frames import table
from crankbase.quantity import RPM
from crankbase.summaries import summarized
from crankfem.analyses.record import Record, assumed_values, attributes
from crankfem.files.hinge_file import HingeFile
from dynamics.hinge.crosshead import KINEMATICS, Kinematics
from dynamics.hinge.profile import (
    BestPressure,
    GasSpring,
    HingeMoment,
    HingeProfile,
    SteadyHingeTurn,
    best_pressure,
    flywheel_for,
    simulate_hinge,
    steady_hinge_turn,
)
from dynamics.turning.speed_over_angle import SpeedOverAngle

if TYPE_CHECKING:
    from matplotlib.axes import Axes


Shown = Literal["moment", "gas force", "speed", "guides"]
SHOWN: tuple[Shown, ...] = ("moment", "gas force", "speed", "guides")


@dataclass(frozen=True, eq=False)
class OtherSpeed:
    """Another operating point with the same guides.

    Parameters
    ----------
    point : HingeMoment
        Of that running point.
    flywheel, flywheel_with_hinge : float
        Inertia that reaches the compared fluctuation without the hinge, and with it at its best
        pressure [kg m^2].
    """

    point: HingeMoment
    best: BestPressure
    flywheel: float
    flywheel_with_hinge: float


@summarized("file.name", "moment.load [N m]", "moment.moment [N m]", "flywheel [kg m^2]", "others")
@dataclass(frozen=True, eq=False)
class HingeRun:
    """All results for a hinge file.

    Parameters
    ----------
    moment : HingeMoment
        For which the guides are designed, with the requested kinematics.
    point : HingeMoment
        The same operating point with exact kinematics, for the free rotation of the crank.
    with_hinge, without : SpeedOverAngle
        A revolution integrated from the top dead center: with the hinge at the mean speed, without it
        from the same speed at the top.
    refused : str or None
        Why the crank does not rotate at the mean speed without the hinge, if it does not.
    flywheel : float
        Inertia that reaches the compared fluctuation without the hinge [kg m^2].
    compared : list of (GasSpring, float, HingeProfile or str)
        Other springs: initial radius, and guides or the reason why there are none.
    deviations : dict
        Largest difference of M_h from that of exact kinematics, relative to the largest M_h, for each of the
        other kinematics.
    """

    file: HingeFile
    moment: HingeMoment
    point: HingeMoment
    profile: HingeProfile
    with_hinge: SpeedOverAngle
    without: SpeedOverAngle
    refused: str | None
    flywheel: float
    flywheel_turn: SteadyHingeTurn
    others: tuple[OtherSpeed, ...]
    compared: list[tuple[GasSpring, float, HingeProfile | str]]
    deviations: dict[Kinematics, float]

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

    def plot(self, axes: "Axes | None" = None, *, show: Shown = "moment") -> "Axes":
        """Draw one diagram of the hinge.

        Parameters
        ----------
        show : str
            "moment" for constant speed, or "gas force", at all operating points; "speed" over a revolution;
            "guides": the rollers' path, for the largest of several springs.

        Raises
        ------
        InputError
            If `show` is unknown.
        """
        from crankfem.analyses.hinge import plots

        check_choice("show", show, SHOWN, "these are diagrams of a hinge")
        if show == "guides":
            return self.plot_guides(axes) if self.compared else self.profile.plot(axes)
        axes = new_axes(axes)
        points = [self.moment, *(other.point for other in self.others)]
        if show == "moment":
            given = [
                (
                    self.profile.moment_at(other.best.pressure, angles_deg=other.point.angles_deg),
                    other.best.pressure,
                )
                for other in self.others
            ]
            plots.draw_moments(axes, points, [None, *given])
        elif show == "gas force":
            plots.draw_gas_force(axes, points)
        else:
            plots.draw_speeds(
                axes,
                self.without,
                self.flywheel_turn,
                self.with_hinge,
                flywheel=self.flywheel,
                from_speed=self.point.speed,
            )
        return axes

    @property
    def spring_sizes(self) -> list[tuple[float, float]]:
        """Height of the spring and initial radius of the compared guides, the largest first [m]."""
        return sorted(
            {(spring.height, radius) for spring, radius, _ in self.compared}, reverse=True
        )

    def plot_guides(self, axes: "Axes | None" = None, size: int = 0) -> "Axes":
        """Draw the rollers' path for all compared springs of one of the `spring_sizes`.

        Parameters
        ----------
        size : int, optional
            Number of the size, the largest by default.
        """
        from crankfem.analyses.hinge.plots import draw_guides

        height, start = self.spring_sizes[size]
        compared = [
            (spring.pressure, guides)
            for spring, radius, guides in self.compared
            if (spring.height, radius) == (height, start)
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
                "speed": ([other.point.speed for other in others], "rad/s"),
                "best_pressure": ([other.best.pressure for other in others], "Pa"),
                "fluctuation": ([other.best.fluctuation for other in others], "1"),
                "flywheel": ([other.flywheel for other in others], "kg m^2"),
                "flywheel_with_hinge": ([other.flywheel_with_hinge for other in others], "kg m^2"),
            }
        )


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
    flywheel = flywheel_for(point, file.operation.flywheel_fluctuation)
    others = [
        other
        for other in (file.speeds if speed is None else (speed,))
        if not math.isclose(other, file.design_speed, rel_tol=1e-6) or speed is not None
    ]
    return HingeRun(
        file=file,
        moment=moment,
        point=point,
        profile=profile,
        with_hinge=simulate_hinge(point, profile),
        without=without,
        refused=_refusal(point),
        flywheel=flywheel,
        flywheel_turn=steady_hinge_turn(point, flywheel=flywheel),
        others=tuple(_other(file, profile, other) for other in others),
        compared=file.compared(moment),
        deviations=_deviations(file, point),
    )


def _refusal(point: HingeMoment) -> str | None:
    try:
        steady_hinge_turn(point)
    except InputError as error:
        return str(error)
    return None


def _other(file: HingeFile, profile: HingeProfile, speed: float) -> OtherSpeed:
    point, wanted = file.moment(speed), file.operation.flywheel_fluctuation
    best = best_pressure(point, profile)
    return OtherSpeed(
        point=point,
        best=best,
        flywheel=flywheel_for(point, wanted),
        flywheel_with_hinge=flywheel_for(point, wanted, profile.with_pressure(best.pressure)),
    )


def _deviations(file: HingeFile, point: HingeMoment) -> dict[Kinematics, float]:
    largest = float(np.max(np.abs(point.moment)))
    return {
        name: float(np.max(np.abs(file.moment(kinematics=name).moment - point.moment))) / largest
        for name in KINEMATICS
        if name != "exact"
    }


def hinge_record(run: HingeRun) -> Record:
    """Return the results as plain numbers in SI units, angles in degrees, speeds in 1/min."""
    spring = run.profile.spring
    return {
        "engine": run.file.name,
        "speed_rpm": run.point.speed * RPM,
        "kinematics": run.moment.kinematics,
        "hinge_moment": _moment_record(run.moment),
        "kinematics_deviation": {str(name): share for name, share in run.deviations.items()},
        "spring": {
            **attributes(spring, "piston_area", "height", "pressure", "exponent"),
            "ambient_pressure": spring.ambient,
        },
        "profile": profile_record(run.profile)
        | {"roller_radius": run.profile.roller_radius, "surface": _surface_record(run.surface)},
        "turning": {
            "with_hinge": _turning_record(run.with_hinge),
            "without": _turning_record(run.without)
            | {"comes_round_at_mean_speed": run.refused is None, "reason": run.refused},
            "flywheel": {
                "inertia": run.flywheel,
                "mean_speed_rpm": run.flywheel_turn.mean_speed * RPM,
                "fluctuation": run.flywheel_turn.fluctuation,
            },
            "remaining_share": run.with_hinge.fluctuation / run.without.fluctuation,
        },
        "other_speeds": [_other_record(other) for other in run.others],
        "compared": [
            {**attributes(other, "height", "pressure"), "start_radius": radius}
            | ({"refused": made} if isinstance(made, str) else profile_record(made))
            for other, radius, made in run.compared
        ],
        "assumed": assumed_values(run.file.records),
    }


def profile_record(profile: HingeProfile) -> Record:
    """Return the properties of guides."""
    return {
        "smallest_radius": float(profile.radius.min()),
        "largest_radius": float(profile.radius.max()),
        "largest_compression": float(profile.compression.max()),
        "least_compression": float(profile.compression.min()),
        "largest_pressure": float(profile.pressure.max()),
        "lowest_pressure": float(profile.pressure.min()),
        "largest_spring_force": float(profile.spring_force.max()),
        "largest_normal_force": float(profile.normal_force.max()),
        "largest_force_angle_deg": float(np.abs(profile.force_angle_deg).max()),
        "checks": [
            {**attributes(check, "name", "met", "value", "limit", "unit"), "meaning": check.reason}
            for check in profile.checks
        ],
        "remarks": list(profile.remarks),
    }


def _surface_record(surface: ComplexArray | None) -> Record | None:
    """Least and largest distance of the guides' surface from the axis."""
    if surface is None:
        return None
    distance = np.abs(surface)
    return {"smallest_radius": float(distance.min()), "largest_radius": float(distance.max())}


def _moment_record(moment: HingeMoment) -> Record:
    degrees = moment.angles_deg
    highest, lowest = int(np.argmax(moment.moment)), int(np.argmin(moment.moment))
    return {
        "load": moment.load,
        "largest": float(moment.moment[highest]),
        "largest_at_deg": float(degrees[highest]),
        "least": float(moment.moment[lowest]),
        "least_at_deg": float(degrees[lowest]),
        "closing_error": moment.closing_error,
        "energy_swing": float(np.ptp(moment.stored_energy)),
        "largest_gas_force": float(moment.gas.max()),
        "reduced_inertia": [
            float(moment.reduced.inertia.min()),
            float(moment.reduced.inertia.max()),
        ],
    }


def _turning_record(turn: SpeedOverAngle) -> Record:
    return {
        "fluctuation": turn.fluctuation,
        "mean_speed_rpm": turn.mean_speed * RPM,
        "lowest_speed_rpm": float(turn.speed.min()) * RPM,
        "highest_speed_rpm": float(turn.speed.max()) * RPM,
    }


def _other_record(other: OtherSpeed) -> Record:
    best = other.best
    return {
        "speed_rpm": other.point.speed * RPM,
        "hinge_moment": _moment_record(other.point),
        **attributes(best, "fitted_ratio", "fluctuation", "moment_residual", "largest_residual"),
        "best_pressure": best.pressure,
        "best_ratio": best.ratio,
        "fluctuation_unchanged": best.unchanged,
        "flywheel_without_hinge": other.flywheel,
        "flywheel_with_hinge": other.flywheel_with_hinge,
    }


def hinge_columns(run: HingeRun) -> dict[str, FloatArray]:
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
        "speed_with_hinge_rad_per_s": _at(run.with_hinge, np.radians(moment.angles_deg)),
        "speed_without_rad_per_s": _at(run.without, np.radians(moment.angles_deg)),
    }


def _at(turn: SpeedOverAngle, angles: FloatArray) -> FloatArray:
    """Return the speed at angles, by linear interpolation between the steps of the integration."""
    return np.interp(angles, np.radians(turn.angle_deg), turn.speed)


# Files of the diagrams; that of the guides is written where springs are compared, that of their surface
# where rollers have a radius.
FILES, GUIDES = ("hinge_moment.svg", "hinge_speed.svg"), "hinge_guides.svg"
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
    if run.compared:
        made.append(folder / GUIDES)
        count = len(run.spring_sizes)
        with figure(made[-1], columns=count, width=4.6 * count, height=4.9) as panels:
            for size, panel in enumerate(np.atleast_1d(panels)):
                run.plot_guides(panel, size)
    if run.surface is not None:
        made.append(folder / SURFACE)
        with figure(made[-1], width=6.4, height=6.8) as axes:
            run.profile.plot(axes)
    return made
