"""Diagrams of the published formulas over the angle between neighboring cranks."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from geometry.diagram_style import GRAY, figure
from regression.formulas.angle_factors import AngleFactors

Array = NDArray[np.float64]

# Colors that stay apart for every kind of color vision (M. Okabe, K. Ito, Color Universal Design,
# 2008), and dashes that keep them apart in print without color.
CURVES: tuple[tuple[str, Any], ...] = (
    ("#0072B2", "-"),
    ("#E69F00", "--"),
    ("#009E73", "-."),
    ("#CC79A7", (0, (1, 1.2))),
    ("#D55E00", (0, (6, 2, 1, 2, 1, 2))),
    ("#56B4E9", "-"),
    ("#8C6D1F", "--"),
    ("#5E3C99", "-."),
    ("#767676", (0, (1, 1.2))),
)
ANGLE_LABEL = r"angle between neighboring cranks $\gamma$ [deg]"


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
        for number, (name, values) in enumerate(formulas.items()):
            color, dashes = CURVES[number % len(CURVES)]
            axes.plot(
                gammas, values * 1e9, color=color, linestyle=dashes, linewidth=1.5, label=name
            )
        axes.plot(gammas, fe * 1e9, color="black", linewidth=2.6, label="finite elements")
        for value, text in zip(bounds, ("guided", "pinned"), strict=True):
            axes.axhline(value * 1e9, color="black", linewidth=0.8, linestyle=":")
            axes.annotate(
                text, (0.0, value * 1e9), xytext=(2, 3), textcoords="offset points", fontsize=8
            )
        axes.set_ylim(bottom=0.0)
        _angle_axis(axes)
        axes.set_ylabel(r"axial compliance $e_\mathrm{n}$ [$10^{-9}$ m/N]")
        axes.legend(fontsize=8, loc="center left", bbox_to_anchor=(1.0, 0.5), handlelength=3.2)


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
                color, dashes = CURVES[number % len(CURVES)]
                panel.plot(
                    gammas,
                    getattr(factors, part),
                    color=color,
                    linestyle=dashes,
                    linewidth=1.7,
                    label=name,
                )
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
            _angle_axis(panel)
            panel.set_ylim(-0.55, 1.05)
        axes[0].set_title("formulas' factor of the crankpin's term", fontsize=10)
        axes[1].set_title("formulas' factor of the web's term", fontsize=10)
        axes[0].set_ylabel(
            r"relative to $\gamma$ = 180 deg: $e(\gamma)\,/\,e_{180}$, $k_\varphi$ [1]"
        )
        axes[1].legend(fontsize=8, loc="center left", bbox_to_anchor=(1.0, 0.5), handlelength=3.2)


def _angle_axis(axes: Any) -> None:
    axes.set_xlim(0.0, 180.0)
    axes.set_xticks(np.arange(0, 181, 30))
    axes.set_xlabel(ANGLE_LABEL)
