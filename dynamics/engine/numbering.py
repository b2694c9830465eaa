"""Numbers of cylinders and throws, which are whole."""

import numpy as np


def is_whole(value: object) -> bool:
    """Tell whether a value is a whole number by its type: neither True nor 2.0 names a cylinder."""
    return isinstance(value, int | np.integer) and not isinstance(value, bool)
