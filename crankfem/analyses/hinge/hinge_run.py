"""Calculation of an elastic hinge: guides, speed fluctuation, other operating points."""

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from crankbase.checks.arrays import ComplexArray
from crankbase.checks.choices import check_choice
from crankbase.drawing.diagram_style import new_axes
from crankbase.errors import InputError
from crankbase.summaries import summarized
from crankbase.tables.frames import table
from crankfem.files.hinge.hinge_file import HingeFile
from dynamics.hinge.crosshead import KINEMATICS, Kinematics
from dynamics.hinge.moment import HingeMoment
from dynamics.hinge.profile import GasSpring, HingeProfile
from dynamics.hinge.simulation import (
    BestPressure,
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
    best : BestPressure
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
    file : HingeFile
    moment : HingeMoment
        For which the guides are designed, with the requested kinematics.
    point : HingeMoment
        The same operating point with exact kinematics, for the free rotation of the crank.
    profile : HingeProfile
    with_hinge, without : SpeedOverAngle
        A revolution integrated from the top dead center: with the hinge at the mean speed, without it
        from the same speed at the top.
    refused : str or None
        Why the crank does not rotate at the mean speed without the hinge, if it does not.
    flywheel : float
        Inertia that reaches the compared fluctuation without the hinge [kg m^2].
    flywheel_turn : SteadyHingeTurn
    others : tuple of OtherSpeed
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
        axes : matplotlib.axes.Axes, optional
            New ones by default.
        show : str
            "moment" for constant speed, or "gas force", at all operating points; "speed" over a revolution;
            "guides": the rollers' path, for the largest of several springs.

        Returns
        -------
        matplotlib.axes.Axes

        Raises
        ------
        InputError
            If `show` is unknown.
        """
        from crankfem.analyses.hinge.plots import hinge_panels

        check_choice("show", show, SHOWN, "these are diagrams of a hinge")
        if show == "guides":
            return self.plot_guides(axes) if self.compared else self.profile.plot(axes)
        axes = new_axes(axes)
        points = [self.moment, *(other.point for other in self.others)]
        if show == "moment":
            given = [
                (
                    self.profile.moment_at(one.best.pressure, angles_deg=one.point.angles_deg),
                    one.best.pressure,
                )
                for one in self.others
            ]
            hinge_panels.draw_moments(axes, points, [None, *given])
        elif show == "gas force":
            hinge_panels.draw_gas_force(axes, points)
        else:
            hinge_panels.draw_speeds(
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
        axes : matplotlib.axes.Axes, optional
            New ones by default.
        size : int, optional
            Number of the size, the largest by default.

        Returns
        -------
        matplotlib.axes.Axes
        """
        from crankfem.analyses.hinge.plots.hinge_panels import draw_guides

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

        Returns
        -------
        pandas.DataFrame
            Units are in ``frame.attrs["units"]``.

        Raises
        ------
        MissingLibraryError
            If pandas is not installed.
        """
        others = self.others
        return table(
            {
                "speed": ([one.point.speed for one in others], "rad/s"),
                "best_pressure": ([one.best.pressure for one in others], "Pa"),
                "fluctuation": ([one.best.fluctuation for one in others], "1"),
                "flywheel": ([one.flywheel for one in others], "kg m^2"),
                "flywheel_with_hinge": ([one.flywheel_with_hinge for one in others], "kg m^2"),
            }
        )


def run_hinge(
    file: HingeFile, kinematics: Kinematics = "exact", speed: float | None = None
) -> HingeRun:
    """Calculate a hinge file.

    Parameters
    ----------
    file : HingeFile
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
