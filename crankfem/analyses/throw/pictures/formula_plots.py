"""Diagrams of the published formulas over the angle between neighboring cranks."""

from collections.abc import Mapping
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from crankbase.drawing.diagram_style import GRAY, figure
from fem.plots.over_angle import angle_axis
from regression.formulas.angle_factors import AngleFactors
from regression.plots.formula_curves import curve_look, draw_over_angle

Array = NDArray[np.float64]


def plot_formulas(
    path: Path, gammas: Array, fe: Array, formulas: Mapping[str, Array], bounds: tuple[float, float]
) -> None:
    """Plot the published formulas and FE over the angle between neighboring cranks.

    Parameters
    ----------
    path : Path
        Of the SVG file.
    gammas : (g,) array
        Angles between neighboring cranks [deg].
    fe : (g,) array
        FE compliance in a helix of that angle [m/N].
    formulas : mapping
        Formula name to (g,) values [m/N], nan where it does not apply.
    bounds : (float, float)
        FE values guided and pinned [m/N].
    """
    with figure(path) as axes:
        draw_over_angle(
            axes, gammas, formulas, fe, dict(zip(("guided", "pinned"), bounds, strict=True))
        )


def plot_angle_factors(
    path: Path,
    gammas: Array,
    law: Array,
    ratio: float,
    formulas: Mapping[str, AngleFactors],
) -> None:
    """Plot the throw's angle law beside the angle factors k_phi of the published formulas.

    All curves are relative to opposite neighbors, gamma = 180 deg. The formulas have one factor for
    the crankpin's term and another for the web's; the law is that of the whole throw, and lies
    where their sum should lie.

    Parameters
    ----------
    path : Path
        Of the SVG file.
    gammas : (g,) array
        Angles between neighboring cranks [deg].
    law : (g,) array
        e(gamma) / e_180 by finite elements.
    ratio : float
        rho of the angle law.
    formulas : mapping of str to AngleFactors
        Name to the factors at `gammas`, as `ANGLE_FACTORS` gives them.
    """
    # The same end values with rho = 1: what a factor linear in cos gamma would make of this throw.
    straight = law[0] + (law[-1] - law[0]) * np.sin(np.deg2rad(gammas) / 2.0) ** 2
    with figure(path, 2, width=9.6, height=4.4) as axes:
        for panel, part in zip(axes, ("pin", "web"), strict=True):
            for number, (name, factors) in enumerate(formulas.items()):
                values = getattr(factors, part)
                panel.plot(gammas, values, **curve_look(number), linewidth=1.7, label=name)
            panel.plot(
                gammas,
                law,
                color="black",
                linewidth=2.6,
                label=rf"finite elements, $\rho$ = {ratio:.2f}",
            )
            panel.plot(
                gammas,
                straight,
                color=GRAY,
                linewidth=1.2,
                label=r"their ends with $\rho$ = 1, linear in cos $\gamma$",
            )
            panel.axhline(0.0, color="black", linewidth=0.8)
            angle_axis(panel)
            panel.set_ylim(-0.55, 1.05)
        axes[0].set_title("formulas' factor of the crankpin's term", fontsize=10)
        axes[1].set_title("formulas' factor of the web's term", fontsize=10)
        axes[0].set_ylabel(
            r"relative to $\gamma$ = 180 deg: $e(\gamma)\,/\,e_{180}$, $k_\varphi$ [1]"
        )
        axes[1].legend(fontsize=8, loc="center left", bbox_to_anchor=(1.0, 0.5), handlelength=3.2)
