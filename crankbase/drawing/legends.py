"""Titles, legends and units, the same on the user's axes as in a figure of the common style."""

from typing import TYPE_CHECKING

from crankbase.errors import visible
from crankbase.units.units import DISPLAY_UNITS

if TYPE_CHECKING:
    from matplotlib.axes import Axes

# Room for the ticks and the label of an axis above a legend [points].
BELOW_AXIS = 34.0
SIZE, TITLE_SIZE = 8, 11


def legend_below(axes: "Axes", columns: int) -> None:
    """Put the legend below the axes, without changing their width."""
    from matplotlib.transforms import ScaledTranslation

    axes.legend(
        fontsize=SIZE,
        loc="upper center",
        bbox_to_anchor=(0.5, 0.0),
        bbox_transform=axes.transAxes
        + ScaledTranslation(0.0, -BELOW_AXIS / 72.0, axes.figure.dpi_scale_trans),
        ncols=columns,
        frameon=False,
    )


def legend_above(axes: "Axes", columns: int = 3) -> None:
    """Put the legend above the curves, next to the title, if curves fill the axes."""
    axes.legend(
        fontsize=SIZE, ncols=columns, loc="lower right", bbox_to_anchor=(1.0, 1.0), frameon=False
    )


def legend_inside(axes: "Axes") -> None:
    """Put the legend where it covers least."""
    axes.legend(fontsize=SIZE, frameon=False)


def write_title(
    axes: "Axes", title: str, size: float = TITLE_SIZE, *, mathematics: bool = False
) -> None:
    """Write a title over the left end of the axes, unchanged, or with math notation between ``$``."""
    shown = title if mathematics else plain_text(title)
    axes.set_title(shown, fontsize=size, loc="left")


def plain_text(text: str) -> str:
    r"""Return a text without math notation for matplotlib, such as a name given by a user.

    Otherwise two ``$`` would begin and end math notation, and invalid notation between them ends the drawing;
    control characters, which no SVG may hold, are written as escapes.
    To be applied once, when the text is passed to matplotlib.

    Examples
    --------
    >>> plain_text("Type $A_{$ 5")
    'Type \\$A_{\\$ 5'
    """
    return visible(text).replace("$", r"\$")


def display_unit(unit: str) -> tuple[str, float]:
    """Return the display unit of an SI unit, as in labels, and that unit's size.

    Parameters
    ----------
    unit : str
        SI; "" for a pure number.

    Examples
    --------
    >>> display_unit("m")
    ('mm', 0.001)
    >>> display_unit("kg"), display_unit("")
    (('kg', 1.0), ('1', 1.0))
    """
    text, size = DISPLAY_UNITS.get(unit, (unit, 1.0))
    return text.replace("1e-9", r"$10^{-9}$") or "1", size
