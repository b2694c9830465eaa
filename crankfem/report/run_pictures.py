"""Static pictures and interactive plots of a run that no other module draws: study, angles, torque."""

import math
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from crankfem.fitting import ResponseFits
from crankfem.pictures import fit_plots, formula_plots
from regression.formulas.angle_factors import ANGLE_FACTORS
from regression.runs.study_table import StudyTable

Names = dict[str, str]


def by_stem(paths: list[Path]) -> Names:
    """Return the names of files by their stems."""
    return {path.stem: path.name for path in paths}


def picture_study(folder: Path, table: StudyTable, fits: ResponseFits) -> Names:
    """Draw the fits of one response of a study.

    Returns
    -------
    dict
        Picture name to file name.
    """
    drawn = {name: f"{name}.svg" for name in ("response", "parity", "effects", "residuals")}
    fit_plots.plot_response(folder / drawn["response"], table, fits)
    fit_plots.plot_parity(folder / drawn["parity"], table, fits)
    fit_plots.plot_effects(folder / drawn["effects"], fits, fits.chosen)
    fit_plots.plot_residuals(folder / drawn["residuals"], table, fits, fits.chosen)
    return drawn


def picture_angles(folder: Path, found: dict[str, Any]) -> Names:
    """Draw finite elements and formulas over the angle between cranks, from the results of a run.

    Returns
    -------
    dict
        Picture name to file name; without "angles" where the webs differ.
    """
    law, supports = found["angle_law"], found["throw"]["supports"]

    def values(column: list[float | None]) -> NDArray[np.float64]:
        return np.array([math.nan if value is None else value for value in column])

    formula_plots.plot_formulas(
        folder / "formulas.svg",
        np.array(law["gamma_deg"]),
        np.array(law["fe"]),
        {name: values(column) for name, column in law["formulas"].items()},
        (supports["guided"]["axial_compliance"], supports["pinned"]["axial_compliance"]),
    )
    if law["law"] is None:
        return {"formulas": "formulas.svg"}
    gammas, fe = np.array(law["gamma_deg"]), np.array(law["fe"])
    factors = {name: factor(gammas) for name, factor in ANGLE_FACTORS.items()}
    formula_plots.plot_angle_factors(
        folder / "angles.svg", gammas, fe / fe[-1], law["law"]["rho"], factors
    )
    return {"formulas": "formulas.svg", "angles": "angles.svg"}
