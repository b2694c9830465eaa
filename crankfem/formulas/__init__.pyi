"""Public names of this topic and their homes."""

from crankfem.analyses.throw.formula_records import plot_formulas as plot_formulas
from crankfem.analyses.throw.formula_records import (
    plot_formulas_over_angle as plot_formulas_over_angle,
)
from crankfem.analyses.throw.formula_records import plot_run_formulas as plot_run_formulas
from regression.formulas.axial_formulas import axial_formula as axial_formula
from regression.formulas.case import FormulaValue as FormulaValue
from regression.formulas.case import formulas_to_pandas as formulas_to_pandas
from regression.law.superelement import law_reactions as law_reactions
from regression.law.throw_law import AxialLaw as AxialLaw
from regression.law.throw_law import TorsionalLaw as TorsionalLaw
from regression.law.throw_law import axial_laws as axial_laws
from regression.law.throw_law import hand_formula as hand_formula
from regression.law.throw_law import mass_law as mass_law
from regression.law.throw_law import torsional_laws as torsional_laws
