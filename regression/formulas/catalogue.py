"""All published axial formulas by name, in the order of the survey."""

from collections.abc import Mapping

from regression.formulas.anderson import ANDERSON
from regression.formulas.dorey import DOREY
from regression.formulas.draminsky import DRAMINSKY_1, DRAMINSKY_2
from regression.formulas.gorbunov import GORBUNOV
from regression.formulas.guglielmotti_macchiotta import GUGLIELMOTTI_MACCHIOTTA
from regression.formulas.reading import AxialFormula
from regression.formulas.skorchev import SKORCHEV
from regression.formulas.stoyanov import STOYANOV
from regression.formulas.tsniimf import TSNIIMF

AXIAL_FORMULAS: Mapping[str, AxialFormula] = {
    formula.name: formula
    for formula in (
        GUGLIELMOTTI_MACCHIOTTA,
        DRAMINSKY_1,
        DRAMINSKY_2,
        TSNIIMF,
        ANDERSON,
        GORBUNOV,
        DOREY,
        SKORCHEV,
        STOYANOV,
    )
}
AXIAL_FORMULA_NAMES: tuple[str, ...] = tuple(AXIAL_FORMULAS)
AXIAL_VARIANTS: tuple[str, ...] = ("corrected", "printed", "plain", "k/4")
