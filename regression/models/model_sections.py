"""A compliance model over one factor as a diagram, over several as a grid, and its responses as a table."""

from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from crankbase.checks.choices import check_not_given
from crankbase.checks.scalars import whole_number
from crankbase.drawing.diagram_style import BLUE, RED, new_axes
from crankbase.drawing.legends import display_unit, write_title
from crankbase.errors import InputError
from crankbase.tables.frames import grid, table
from fem.plots.over_angle import angle_axis
from regression.models.family import Family
from regression.models.lookup import Lookup
from regression.models.response_model import ResponseModel
from regression.plans.factors import rounded
from regression.plots.factor_axis import POINTS, factor_size, label_factor_axis, response_text

if TYPE_CHECKING:
    from matplotlib.axes import Axes

Array = NDArray[np.float64]

ANGLE = "gamma_deg"
MOST_POINTS = 1_000_000
# What a table says of each response.
WORDS = ("symbol", "unit", "support", "form")
ERRORS = ("largest_error", "largest_heldout_error", "largest_fe_error")


def plot_section(
    axes: "Axes | None",
    family: Family,
    lookup: Callable[..., Lookup],
    response: str,
    over: str | None,
    gamma_deg: float | None,
    dimensions: Mapping[str, Any],
) -> "Axes":
    """Draw a response over one factor; see `ComplianceModel.plot`."""
    factor = next(iter(family.ranges)) if over is None else over
    if factor != ANGLE and factor not in family.ranges:
        raise InputError(
            f"over: given {over!r}; allowed are {', '.join((*family.ranges, ANGLE))}, because the model is "
            "evaluated over these."
        )
    given = gamma_deg if factor == ANGLE else dimensions.get(factor)
    check_not_given(factor, given, f"over={factor}", "the diagram sweeps it over its whole range")
    low, high = (0.0, 180.0) if factor == ANGLE else family.ranges[factor]
    values = np.linspace(low, high, POINTS)
    asked = {key: v for key, v in middle(family).items() if key != factor} | dict(dimensions)
    found: list[Lookup] = [
        lookup(response, **{**asked, ANGLE: gamma_deg, factor: value}) for value in values.tolist()
    ]
    size = display_unit(found[0].unit)[1]
    axes = new_axes(axes)
    unit = family.unit(factor) if factor != ANGLE else "deg"
    x = values / (1.0 if factor == ANGLE else factor_size(unit, ()))
    y = np.array([one.value for one in found]) / size
    axes.plot(x, y, color=BLUE, label="equation")
    band = np.array([(one.lower, one.upper) for one in found], dtype=np.float64) / size
    if np.isfinite(band).all(axis=1).any():
        axes.fill_between(x, *band.T, color=BLUE, alpha=0.2, linewidth=0.0, label="error band")
    outside = np.array([not one.inside for one in found])
    if outside.any():
        beyond = np.where(outside, y, np.nan)
        axes.plot(x, beyond, color=RED, linestyle="--", label="outside the range of the fit")
    if factor == ANGLE:
        angle_axis(axes)
    else:
        label_factor_axis(axes, factor, unit, ())
    axes.set_ylabel(response_text(found[0].symbol.partition("(")[0], found[0].unit))
    write_title(axes, f"{response.replace('_', ' ')}, {found[0].support}".rstrip(", "))
    axes.legend(
        frameon=False, title=_others(family, asked, gamma_deg), title_fontsize=8, fontsize=8
    )
    return axes


def response_table(responses: Mapping[str, ResponseModel]) -> Any:
    """Return a pandas table of a model's responses; an unknown error is None."""
    columns: dict[str, tuple[Any, str]] = {"response": (list(responses), "")}
    for names, unit in ((WORDS, ""), (ERRORS, "1"), (("equation",), "")):
        for name in names:
            columns[name] = ([getattr(one, name) for one in responses.values()], unit)
    return table(columns)


def response_grid(
    family: Family,
    value: Callable[..., ArrayLike],
    responses: Mapping[str, ResponseModel],
    names: Sequence[str],
    points: int,
    gamma_deg: ArrayLike | None,
    dimensions: Mapping[str, Any],
) -> Any:
    """Return responses on a grid of factors as an xarray dataset; see `ComplianceModel.to_xarray`."""
    most = whole_number("points", points, 2, "a factor's range has two ends")
    given: dict[str, Any] = dict(dimensions)
    if gamma_deg is not None:
        given[ANGLE] = gamma_deg
    sides = {name: np.asarray(value) for name, value in given.items() if np.ndim(value) == 1}
    fixed = {name: value for name, value in given.items() if name not in sides}
    if not sides:
        sides = {
            name: np.array([rounded(value) for value in np.linspace(*ends, most).tolist()])
            for name, ends in family.ranges.items()
            if name not in fixed
        }
    count = int(np.prod([len(values) for values in sides.values()]))
    if count > MOST_POINTS:
        raise InputError(
            f"points: given a grid of {count:,}; allowed are {MOST_POINTS:,}, because more fill the memory; "
            "give fewer points, or arrays of some factors only."
        )
    others = {n: v for n, v in middle(family).items() if n not in sides} | fixed
    asked = others | dict(zip(sides, np.meshgrid(*sides.values(), indexing="ij"), strict=True))
    variables = {}
    for name in names or tuple(responses):
        values = np.broadcast_to(value(name, **asked), [len(v) for v in sides.values()])
        one = responses[name]
        words = f"{name.replace('_', ' ')}, {one.support}".rstrip(", ")
        variables[name] = (tuple(sides), values, one.unit or "1", words)
    coordinates = {
        name: (values, "deg" if name == ANGLE else family.unit(name) or "1", name.replace("_", " "))
        for name, values in sides.items()
    }
    made = grid(variables, coordinates)
    made.attrs |= others
    return made


def middle(family: Family) -> dict[str, float | str]:
    """Return the middle of each factor's range, and the first label of each choice."""
    numbers = {name: 0.5 * (low + high) for name, (low, high) in family.ranges.items()}
    return numbers | {name: labels[0] for name, labels in family.categories.items()}


def _others(family: Family, asked: Mapping[str, Any], gamma_deg: float | None) -> str:
    """State the values of the other factors."""
    shown = [
        f"{name.replace('_', ' ')} {v if isinstance(v, str) else family.format_value(name, float(v))}"
        for name, v in asked.items()
    ]
    if gamma_deg is not None:
        shown.append(f"neighbors at {gamma_deg:g} deg")
    return "\n".join(shown)
