"""Axial compliance over the angle between neighboring cranks: finite elements and formulas."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from crankbase.drawing.diagram_style import CURVES, GRAY, make_folder
from crankfem.report.interactive.style import (
    QUIET_COLOR,
    Figure,
    Part,
    axis,
    choice,
    layout,
    level,
    line,
    literal,
    shown_in_turn,
)
from crankfem.report.interactive.writing import write_figure
from regression.formulas.angle_factors import ANGLE_FACTORS, AngleFactors

Array = NDArray[np.float64]

NANO = 1e9
FE_COLOR = "#000000"
ANGLE_TITLE = "angle between neighboring cranks γ [deg]"
PARTS = {"pin": "the crankpin's term", "web": "the web's term"}


def interactive_angles(folder: Path, record: Mapping[str, Any]) -> list[Path]:
    """Write the interactive diagrams over the angle between cranks, in a folder made if not there.

    Parameters
    ----------
    folder : Path
    record : mapping
        Results of a run: its "angle_law" and "throw".

    Returns
    -------
    list of Path
        ``formulas.json``, and ``angles.json`` where the throw has an angle law.

    Raises
    ------
    InputError
        If the folder or a file cannot be written.
    """
    make_folder(folder)
    law, supports = record["angle_law"], record["throw"]["supports"]
    gammas, fe = np.array(law["gamma_deg"]), np.array(law["fe"])
    # None becomes nan.
    formulas = {
        name: np.array(values, dtype=np.float64) for name, values in law["formulas"].items()
    }
    bounds = {name: supports[name]["axial_compliance"] for name in ("guided", "pinned")}
    made = [
        write_figure(folder / "formulas.json", *formulas_over_angle(gammas, fe, formulas, bounds))
    ]
    if law["law"] is not None:
        factors = {name: factor(gammas) for name, factor in ANGLE_FACTORS.items()}
        figure = angle_factors(gammas, fe / fe[-1], law["law"]["rho"], factors)
        made.append(write_figure(folder / "angles.json", *figure))
    return made


def formulas_over_angle(
    gammas: Array, fe: Array, formulas: Mapping[str, Array], bounds: Mapping[str, float]
) -> Figure:
    """Draw the published formulas and finite elements over the angle between neighboring cranks.

    Parameters
    ----------
    gammas : (g,) array
        [deg]
    fe : (g,) array
        FE compliance in a helix of that angle [m/N].
    formulas : mapping
        Formula name to (g,) values [m/N], nan where it does not apply.
    bounds : mapping
        Support to its FE value [m/N].

    Returns
    -------
    traces : list of dict
    layout : dict
    """
    told = "<br>γ = %{x:.4g} deg<br>%{y:.4g}·10<sup>-9</sup> m/N"
    traces = [
        line(
            gammas,
            NANO * fe,
            "finite elements",
            FE_COLOR,
            f"<b>finite elements</b>{told}",
            width=3.2,
        )
    ]
    for number, (name, values) in enumerate(formulas.items()):
        color, dash = CURVES[number % len(CURVES)]
        traces.append(
            line(gammas, NANO * values, name, color, literal(name) + told, width=2.0, dash=dash)
        )
    notes = [
        {
            "x": 0.0,
            "xref": "paper",
            "xanchor": "left",
            "y": NANO * value,
            "yanchor": "bottom",
            "text": f"FE {name}: {NANO * value:.4g}",
            "showarrow": False,
            "font": {"size": 11, "color": QUIET_COLOR},
        }
        for name, value in bounds.items()
    ]
    lines = [
        level(NANO * value, FE_COLOR) | {"line": {"color": FE_COLOR, "width": 1, "dash": "dot"}}
        for value in bounds.values()
    ]
    return traces, layout(
        _angle_axis(),
        axis("axial compliance e<sub>n</sub> [10<sup>-9</sup> m/N]", rangemode="tozero"),
        title="Axial compliance, finite elements and formulas",
        height=470,
        shapes=lines,
        annotations=notes,
    )


def angle_factors(
    gammas: Array, law: Array, ratio: float, formulas: Mapping[str, AngleFactors]
) -> Figure:
    """Draw the throw's angle law beside the formulas' factors of one term at a time.

    Parameters
    ----------
    gammas : (g,) array
        [deg]
    law : (g,) array
        e(gamma) / e_180 by finite elements.
    ratio : float
        rho of the angle law.
    formulas : mapping of str to AngleFactors

    Returns
    -------
    traces : list of dict
        Law, its ends joined with rho = 1, then the formulas' factors of both terms; a menu chooses.
    layout : dict
    """
    # The same end values with rho = 1: what a factor linear in cos gamma would make of this throw.
    straight = law[0] + (law[-1] - law[0]) * np.sin(np.deg2rad(gammas) / 2.0) ** 2
    told = "<br>γ = %{x:.4g} deg<br>%{y:.4g} of the value at 180 deg"
    name = f"finite elements, ρ = {ratio:.2f}"
    traces: list[Part] = [
        line(gammas, law, name, FE_COLOR, f"<b>{name}</b>{told}", width=3.2),
        line(gammas, straight, "their ends with ρ = 1", GRAY, f"ends with ρ = 1{told}", width=1.4),
    ]
    owners = []
    for place, part in enumerate(PARTS):
        for number, (name, factors) in enumerate(formulas.items()):
            color, dash = CURVES[number % len(CURVES)]
            values = getattr(factors, part)
            traces.append(
                line(
                    gammas,
                    values,
                    name,
                    color,
                    literal(name) + told,
                    width=2.0,
                    dash=dash,
                    visible=place == 0,
                )
            )
            owners.append(place)
    changes = [
        [{"visible": [True, True, *visible]}] for visible in shown_in_turn(owners, len(PARTS))
    ]
    return traces, layout(
        _angle_axis(),
        axis(
            "relative to γ = 180 deg: e(γ)/e<sub>180</sub>, k<sub>φ</sub> [1]", range=[-0.55, 1.05]
        ),
        title="Angle law and the formulas' factors",
        height=470,
        shapes=[level(0.0, FE_COLOR)],
        updatemenus=[choice("formulas' factor of", list(PARTS.values()), changes)],
    )


def _angle_axis() -> Part:
    return axis(ANGLE_TITLE, range=[0, 180], dtick=30, tick0=0)
