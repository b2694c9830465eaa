"""Static pictures of a run that no other command draws: its study, and compliances over the angle."""

import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from crankfem.analyses.study.fitting import ResponseFits
from crankfem.analyses.study.plots import fit_plots
from crankfem.analyses.throw.pictures import formula_plots
from crankfem.analyses.to_draw import ToDraw
from regression.runs.study_table import StudyTable


def study_pictures(folder: Path, table: StudyTable, fits: ResponseFits) -> list[ToDraw]:
    """Return the pictures of one response of a study, still to be drawn into a folder."""
    chosen = fits.chosen
    return [
        ToDraw(folder / "response.svg", lambda path: fit_plots.plot_response(path, table, fits)),
        ToDraw(folder / "parity.svg", lambda path: fit_plots.plot_parity(path, table, fits)),
        ToDraw(folder / "effects.svg", lambda path: fit_plots.plot_effects(path, fits, chosen)),
    ]


def angle_pictures(folder: Path, found: Mapping[str, Any]) -> list[ToDraw]:
    """Return the picture of compliances over the angle between cranks, from the results of a run."""
    law, supports = found["angle_law"], found["throw"]["supports"]
    gammas, fe = np.array(law["gamma_deg"]), np.array(law["fe"])

    def values(column: list[float | None]) -> NDArray[np.float64]:
        return np.array([math.nan if value is None else value for value in column])

    def draw_formulas(path: Path) -> None:
        formula_plots.plot_formulas(
            path,
            gammas,
            fe,
            {name: values(column) for name, column in law["formulas"].items()},
            (supports["guided"]["axial_compliance"], supports["pinned"]["axial_compliance"]),
        )

    return [ToDraw(folder / "formulas.svg", draw_formulas)]
