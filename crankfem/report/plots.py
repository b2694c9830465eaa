"""All plots of a run, and the words of each by its name."""

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from crankfem.analyses.mechanism.plots import plot_torque
from crankfem.analyses.study.plots import fit_plots
from crankfem.analyses.study.response_fits import ResponseFits
from crankfem.analyses.throw.formula_records import run_formulas_over_angle
from crankfem.report.interactive.mechanism import MECHANISM
from crankfem.report.interactive.plot import Plot, Plots, plot_of_curves
from crankfem.report.interactive.study import parity, response_over_factors
from crankfem.report.interactive.vibration import VIBRATION
from dynamics.harmonics import Harmonics
from regression.runs.study_table import StudyTable

Array = NDArray[np.float64]

STUDY: Plots[tuple[StudyTable, ResponseFits]] = Plots(
    (
        Plot(
            "response",
            "Axial compliance over each factor",
            "Axial compliance over each factor, the others at their middle.",
            lambda path, study: fit_plots.plot_response(path, *study),
            lambda study: response_over_factors(*study),
        ),
        Plot(
            "parity",
            "Equation against finite elements for each form",
            "Each form against finite elements; on the line they agree.",
            lambda path, study: fit_plots.plot_parity(path, *study),
            lambda study: parity(*study),
        ),
        Plot(
            "effects",
            "Coded coefficients by size",
            "Effects: the coefficients of the chosen form in coded variables, by size.",
            lambda path, study: fit_plots.plot_effects(path, study[1], study[1].chosen),
        ),
    )
)


ANGLES: Plots[Mapping[str, Any]] = Plots(
    (
        plot_of_curves(
            "formulas",
            "Axial compliance over the angle between neighboring cranks",
            "Axial compliance over the angle between neighboring cranks: finite elements in a helix of equal "
            "throws, and the formulas. Formulas without an angle are level lines.",
            run_formulas_over_angle,
            lambda _: "Axial compliance, finite elements and formulas",
        ),
    )
)


TORQUE: Plots[tuple[Array, Harmonics]] = Plots(
    (
        Plot(
            "torque",
            "Torque over a cycle and its harmonics",
            "Torque of one throw with the sum of its harmonics, and the amplitude of each order.",
            lambda path, torque: plot_torque(path, *torque),
        ),
    )
)
# Those that are drawn or rendered on their own, for each throw or in the background.
THROW: tuple[Plot[None], ...] = (
    Plot(
        "throw_view",
        "The crank throw in three dimensions: solid, mesh, deformed by an axial force, fillet stress",
        "The throw in three dimensions: turn it with the mouse; the menu shows the solid, the mesh, its "
        "deformation by an axial force and the stress at the fillets.",
    ),
    Plot(
        "drawing",
        "Dimensioned drawing of the crank throw: side view and view from the left end",
        "The throw as described in the file, to scale.",
    ),
    Plot(
        "stress_radial",
        "Equivalent stress of the crank throw under a radial force on the pin",
        "Under a radial force on the pin; a ring marks the largest stress at a fillet, a square that at an "
        "oil hole.",
    ),
    Plot(
        "stress_torsion", "Equivalent stress of the crank throw under a torque", "Under a torque."
    ),
)
PLOTS: dict[str, Plot[Any]] = {
    plot.name: plot
    for plots in (MECHANISM, STUDY, TORQUE, VIBRATION, ANGLES)
    for plot in plots.plots
} | {plot.name: plot for plot in THROW}
