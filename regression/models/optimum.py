"""Results of an optimum search: the best throw, and the use of its limits."""

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from crankbase.drawing.bars import draw_groups
from crankbase.drawing.diagram_style import RED, new_axes
from crankbase.drawing.legends import write_title
from crankbase.errors import InputError
from crankbase.summaries import summarized
from crankbase.tables.frames import table
from crankbase.units.quantity import format_quantity
from geometry.throw import CrankThrow
from regression.models.lookup import Lookup
from regression.models.optimum_limits import Limit
from regression.throw_values import field_unit

if TYPE_CHECKING:
    from matplotlib.axes import Axes


@dataclass(frozen=True)
class LimitCheck:
    """A limit at the optimum.

    Attributes
    ----------
    limit : Limit
    value : float
        By the equation.
    worst : float
        At the worst end of the error band, which keeps the bound.
    active : bool
        Whether the optimum is at this limit.
    """

    limit: Limit
    value: float
    worst: float
    active: bool


@summarized("minimized", "value", "unit", "factors", "limits", "remarks", keeps_text=True)
@dataclass(frozen=True)
class Optimum:
    """The best throw under limits.

    Attributes
    ----------
    minimized : str
        Minimized quantity: a dimension or a response.
    value : float
        Its value [SI]; of a response, by the equation.
    unit : str
    dimensions : dict
        All known dimensions and labels of the throw.
    factors : dict
        The model's factors.
    limits : tuple of LimitCheck
    at_ends : tuple of str
        Factors at an end of their range.
    lookups : dict of str to Lookup
        All responses of the model at the optimum.
    throw : CrankThrow or None
        The throw, if the model contains the one that was varied and this can be built.
    remarks : tuple of str
    evaluations : int
        Designs evaluated.
    """

    minimized: str
    value: float
    unit: str
    dimensions: dict[str, float | str]
    factors: dict[str, float | str]
    limits: tuple[LimitCheck, ...]
    at_ends: tuple[str, ...]
    lookups: dict[str, Lookup]
    throw: CrankThrow | None
    remarks: tuple[str, ...]
    evaluations: int

    def __repr__(self) -> str:
        """Summarize the optimum in a line; throw and lookups would fill screens."""
        at = ", ".join(
            f"{name} {value if isinstance(value, str) else f'{value:.6g}'}"
            for name, value in self.factors.items()
        )
        active = ", ".join(one.limit.name for one in self.limits if one.active)
        limits = f", at the limit of {active}" if active else ""
        return (
            f"Optimum({self.minimized} {self.value:.6g} {self.unit}".rstrip() + f" at {at}{limits})"
        )

    def plot(self, axes: "Axes | None" = None) -> "Axes":
        """Draw the use of each limit, by the equation and at the worst end of its error band.

        Parameters
        ----------
        axes : matplotlib.axes.Axes, optional
            New ones by default.

        Returns
        -------
        matplotlib.axes.Axes

        Raises
        ------
        InputError
            If the optimum was found without limits, or a bound is 0.
        """
        if not self.limits or any(check.limit.bound == 0.0 for check in self.limits):
            raise InputError(
                f"limits: given {', '.join(c.limit.name for c in self.limits) or 'none'}; allowed for a "
                "plot are one or more whose bound is not 0, because values are drawn as a share of it."
            )
        names = [
            f"{one.limit.name} {one.limit.sign} {format_quantity(one.limit.bound, one.limit.unit)}"
            for one in self.limits
        ]
        shares = {
            "by the equation": [100.0 * one.value / one.limit.bound for one in self.limits],
            "worst in its error band": [100.0 * one.worst / one.limit.bound for one in self.limits],
        }
        axes = new_axes(axes)
        draw_groups(axes, names, shares, "share of the bound [%]")
        axes.axhline(100.0, color=RED, linestyle="--", linewidth=1.2)
        write_title(axes, f"Limits at the least {self.minimized.replace('_', ' ')}")
        return axes

    def to_pandas(self) -> Any:
        """Return a table of the optimum: its factors, its other dimensions, and its responses.

        Returns
        -------
        pandas.DataFrame
            ``name``, ``kind`` ("factor", "dimension", "response"), ``value`` [SI] and ``unit``.

        Raises
        ------
        MissingLibraryError
            If pandas is not installed.
        """
        rows: list[tuple[str, str, float | str, str]] = [
            (name, "factor" if name in self.factors else "dimension", value, field_unit(name) or "")
            for name, value in {**self.factors, **self.dimensions}.items()
        ]
        rows += [(name, "response", one.value, one.unit) for name, one in self.lookups.items()]
        names, kinds, values, units = zip(*rows, strict=True)
        return table(
            {
                "name": (names, ""),
                "kind": (kinds, ""),
                "value": (values, "SI, see the column unit"),
                "unit": (units, ""),
            }
        )
