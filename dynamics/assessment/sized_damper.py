"""Result of the optimization of a damper."""

from dataclasses import dataclass
from typing import Literal

from crankbase.checks.arrays import FloatArray
from crankbase.checks.choices import check_choice
from crankbase.drawing.diagram_style import BLUE, RED, new_axes, with_gaps
from crankbase.drawing.legends import legend_inside, write_title
from crankbase.library_types import Axes, DataFrame
from crankbase.summaries import summarized
from crankbase.tables.frames import table
from crankbase.units.units import RPM
from dynamics.assessment.limits import AmplitudeCurve, VibrationLimit
from dynamics.chains.chain import Chain
from dynamics.chains.dampers import AxialDamper, TorsionalDamper
from dynamics.plots.quantities import in_unit
from dynamics.plots.speed_curves import draw_named_curves

Damper = TorsionalDamper | AxialDamper


@summarized("damper", "used", "used_without", "reached", "sizes")
@dataclass(frozen=True, eq=False)
class SizedDamper:
    """Result of the optimization of a damper.

    Parameters
    ----------
    damper : ViscousDamper, RubberDamper or AxialDamper
        The smallest one that keeps the limit; if none does, the one with the least excess.
    chain : Chain
        Chain with this damper.
    reached : bool
        Whether the limit is kept.
    limit : VibrationLimit
    curve, without : AmplitudeCurve
        The limited quantity with the damper and without one.
    used, used_without : float
        Largest share of the permitted amplitude over the speeds; infinite at an undamped resonance.
    sizes : ndarray of shape (m,)
        Sizes tried, ascending, without those at the end of the search that nearly equal the best: ring
        inertia [kg m^2] or damping of an axial damper [N s/m].
    used_at_best : ndarray of shape (m,)
        Least share of the permitted amplitude found for each of them.
    sentence : str
        The result, or why no damper keeps the limit.
    """

    damper: Damper
    chain: Chain
    reached: bool
    limit: VibrationLimit
    curve: AmplitudeCurve
    without: AmplitudeCurve
    used: float
    used_without: float
    sizes: FloatArray
    used_at_best: FloatArray
    sentence: str

    def plot(
        self, axes: Axes | None = None, *, show: Literal["amplitude", "sizes"] = "amplitude"
    ) -> Axes:
        """Draw the amplitude with and without the damper, or the best result of each size.

        Parameters
        ----------
        axes : matplotlib.axes.Axes, optional
            Where to draw; new axes by default.
        show : {"amplitude", "sizes"}, optional
            Amplitude over the speed, or the best result of each size.

        Returns
        -------
        matplotlib.axes.Axes
            The dashed line is the permitted value.

        Raises
        ------
        InputError
            If it is neither.
        """
        check_choice("show", show, ("amplitude", "sizes"), "these show what a damper does")
        axes = new_axes(axes)
        if show == "sizes":
            unit = "N s/m" if isinstance(self.damper, AxialDamper) else "kg m$^2$"
            axes.plot(
                self.sizes, with_gaps(100.0 * self.used_at_best), "o-", color=BLUE, markersize=4
            )
            axes.axhline(100.0, color=RED, linestyle="--", linewidth=1.2)
            axes.set_xlabel(f"size of the damper [{unit}]")
            axes.set_ylabel("used of the permitted amplitude [%]")
            axes.set_ylim(bottom=0.0)
            write_title(axes, "Dampers of each size at their best")
            return axes
        drawn = in_unit(self.limit.unit)
        curves = {
            "with the damper": drawn.factor * self.curve.values,
            "without": drawn.factor * self.without.values,
        }
        draw_named_curves(axes, self.curve.speeds, curves, drawn.label)
        permitted = drawn.factor * self.limit.continuous.at(self.curve.speeds)
        rpm = RPM * self.curve.speeds
        axes.plot(rpm, with_gaps(permitted), "--", color=RED, label="permitted")
        write_title(axes, self.limit.name)
        legend_inside(axes)
        return axes

    def to_pandas(self) -> DataFrame:
        """Return a row for each size, with the least share of the permitted amplitude found.

        Returns
        -------
        pandas.DataFrame
            Units of the columns in ``attrs["units"]``.

        Raises
        ------
        MissingLibraryError
            If pandas is not installed.
        """
        unit = "N s/m" if isinstance(self.damper, AxialDamper) else "kg m^2"
        return table({"size": (self.sizes, unit), "used": (self.used_at_best, "1")})
