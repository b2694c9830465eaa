"""The modes of the whole crankshaft."""

import numpy as np
from numpy.typing import NDArray

from crankbase.drawing.diagram_style import BLUE, GREEN, ORANGE
from crankfem.report.interactive.style import (
    Figure,
    Part,
    axis,
    choice,
    layout,
    level,
    line,
    visibility_by_choice,
)
from dynamics.crankshaft.shaft_modes import ShaftModes
from dynamics.crankshaft.shaft_throw import RZ, UX, UY, UZ

Array = NDArray[np.float64]

MODES_SHOWN = 10


def shaft_modes(modes: ShaftModes, radius: float, title: str) -> Figure:
    """Draw axial, torsional and lateral motion along the shaft, one elastic mode at a time.

    Parameters
    ----------
    modes : ShaftModes
    radius : float
        Crank radius: rotation about the shaft is shown as the displacement there [m].
    title : str

    Returns
    -------
    traces : list of dict
        Four for each mode; a menu chooses the mode.
    layout : dict
    """
    shown = range(modes.rigid, min(modes.rigid + MODES_SHOWN, len(modes.names)))
    order = np.argsort(modes.positions, kind="stable")
    places = 1e3 * modes.positions[order]
    traces: list[Part] = []
    labels = []
    for count, mode in enumerate(shown):
        motion = modes.motions[order, :, mode]
        curves = {
            "axial": motion[:, UZ],
            "torsional, at the crank radius": radius * motion[:, RZ],
            "lateral, x": motion[:, UX],
            "lateral, y": motion[:, UY],
        }
        every = np.concatenate(list(curves.values()))
        # The largest displacement is 1.
        largest = every[np.argmax(np.abs(every))] or 1.0
        labels.append(f"{modes.frequencies[mode]:.1f} Hz: {modes.label(mode)}")
        for (name, curve), color, dash in zip(
            curves.items(),
            (BLUE, ORANGE, GREEN, GREEN),
            ("solid", "solid", "solid", "dash"),
            strict=True,
        ):
            traces.append(
                line(
                    places,
                    curve / largest,
                    name,
                    color,
                    f"{name}<br>%{{y:.3f}} of the largest<br>at %{{x:.5g}} mm",
                    dash=dash,
                    mode="lines+markers",
                    marker={"size": 5},
                    visible=count == 0,
                )
            )
    turns = visibility_by_choice(np.repeat(np.arange(len(labels)), 4).tolist(), len(labels))
    return traces, layout(
        axis("position along the shaft [mm]"),
        axis("relative displacement [1]", range=[-1.1, 1.1]),
        title=title,
        shapes=[level(0.0)],
        updatemenus=[choice("mode", labels, [[{"visible": turn}] for turn in turns])],
    )
