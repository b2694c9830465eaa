"""Types of libraries that are loaded on demand: axes, tables and grids."""

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from matplotlib.axes import Axes as Axes
    from pandas import DataFrame as DataFrame
    from xarray import Dataset as Dataset
else:
    Axes = DataFrame = Dataset = Any
