"""The Campbell diagram of a system: natural frequencies, order lines, and resonances on them."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

from numpy.typing import ArrayLike

from dynamics.checks import finite_vector
from dynamics.plots.campbell import draw_campbell
from dynamics.response.resonance import Resonance
from geometry.diagram_style import new_axes
from geometry.plots.legends import write_title

if TYPE_CHECKING:
    from matplotlib.axes import Axes


def campbell_diagram(
    frequencies: ArrayLike,
    orders: ArrayLike,
    speed_range: tuple[float, float],
    found: Sequence[Resonance] = (),
    axes: "Axes | None" = None,
) -> "Axes":
    """Draw natural frequencies and order lines over speed, with a dot at each resonance.

    Parameters
    ----------
    frequencies : array_like of shape (n,)
        Natural frequencies of elastic modes [Hz]; those above the range of the orders are left out.
    orders : array_like of shape (K,)
        In cycles per crankshaft revolution.
    speed_range : tuple of two floats
        Running range [rad/s], shaded.
    found : sequence of Resonance, optional
        Dots grow with their severity.
    axes : matplotlib.axes.Axes, optional
        Where to draw; those of a new figure if not given.

    Returns
    -------
    matplotlib.axes.Axes

    Raises
    ------
    InputError
        If frequencies or orders are not finite numbers in a row.
    """
    natural, lines = finite_vector("frequencies", frequencies), finite_vector("orders", orders)
    axes = new_axes(axes, height=4.8)
    draw_campbell(axes, natural, lines, speed_range, found)
    write_title(axes, "Campbell diagram")
    return axes
