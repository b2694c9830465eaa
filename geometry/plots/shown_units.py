"""Units on the axes of diagrams."""

from geometry.units import DISPLAY_UNITS


def shown_unit(unit: str) -> tuple[str, float]:
    """Return what an axis says of an SI unit, and the size of the unit it is shown in.

    Parameters
    ----------
    unit : str
        SI; "" for a pure number.

    Examples
    --------
    >>> shown_unit("m")
    ('mm', 0.001)
    >>> shown_unit("kg"), shown_unit("")
    (('kg', 1.0), ('1', 1.0))
    """
    text, size = DISPLAY_UNITS.get(unit, (unit, 1.0))
    return text.replace("1e-9", r"$10^{-9}$") or "1", size
