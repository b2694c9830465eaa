"""The coded coefficients of a fit in the order of their size."""

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from regression.factor_labels import term_text
from regression.fits.equation_text import term_symbols

if TYPE_CHECKING:
    from regression.fits.fits import Fit


def term_effects(fit: "Fit") -> tuple[list[str], NDArray[np.float64]]:
    """Return terms, as diagrams write them, and their coded coefficients, the largest first.

    The constant is left out.
    """
    values = dict(zip(term_symbols(fit.fitted), fit.fitted.coefficients, strict=True))
    order = sorted(values, key=lambda name: -abs(values[name]))
    order.remove("1")
    return [term_text(name) for name in order], np.array([values[name] for name in order])
