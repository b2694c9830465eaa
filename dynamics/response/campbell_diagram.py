"""The Campbell diagram of a system: natural frequencies, order lines, and resonances on them."""

from collections.abc import Sequence

from numpy.typing import ArrayLike

from crankbase.checks.arrays import checked_range, nonnegative_vector, positive_vector
from crankbase.drawing.diagram_style import new_axes
from crankbase.drawing.legends import write_title
from crankbase.errors import InputError
from crankbase.library_types import Axes
from dynamics.plots.campbell import draw_campbell
from dynamics.response.resonance import Resonance


def campbell_diagram(
    frequencies: ArrayLike,
    orders: ArrayLike,
    speed_range: tuple[float, float],
    found: Sequence[Resonance] = (),
    axes: Axes | None = None,
) -> Axes:
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
        Where to draw; new axes by default.

    Returns
    -------
    matplotlib.axes.Axes

    Raises
    ------
    InputError
        If frequencies are not a row of finite numbers of zero or more, orders not finite numbers above
        zero, at least one, or the range is not two speeds, the lower first.
    """
    natural = nonnegative_vector("frequencies", frequencies, "Hz", "modes swing at them")
    lines = positive_vector("orders", orders, "", "their lines rise with the speed")
    if not lines.size:
        raise InputError(
            "orders: given none; allowed is one or more, because their lines set the height."
        )
    ends = checked_range("speed_range", speed_range, "rad/s", "it is shaded")
    axes = new_axes(axes, height=4.8)
    draw_campbell(axes, natural, lines, ends, found)
    write_title(axes, "Campbell diagram")
    return axes
