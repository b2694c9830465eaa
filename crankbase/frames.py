"""The optional packages for tables, grids and axes: pandas, xarray and matplotlib, loaded on demand."""

from collections.abc import Iterable, Mapping
from importlib import import_module
from typing import TYPE_CHECKING, Any, Protocol, TypeAlias

import numpy as np

from crankbase.errors import MissingLibraryError

if TYPE_CHECKING:
    from matplotlib.axes import Axes as Axes
    from pandas import DataFrame as DataFrame
    from xarray import Dataset as Dataset
else:
    Axes = DataFrame = Dataset = Any

# What one row of a table shows: each value with its unit in SI.
Row: TypeAlias = dict[str, tuple[Any, str]]


class Record(Protocol):
    """A row of a table of results."""

    def row(self) -> Row:
        """Return its values by column, each with its unit."""


def table(columns: Mapping[str, tuple[Any, str]]) -> Any:
    """Return a pandas table of columns with their units.

    Parameters
    ----------
    columns : mapping of str to tuple
        The values and the unit of each column, in order. "1" is the unit of plain numbers; a column
        of words has the unit "".

    Returns
    -------
    pandas.DataFrame
        With the units in ``frame.attrs["units"]``, by column.

    Raises
    ------
    MissingLibraryError
        If pandas is not installed.

    Examples
    --------
    >>> frame = table({"frequency": ([12.0, 31.5], "Hz")})
    >>> frame.attrs["units"]
    {'frequency': 'Hz'}
    """
    frame = _load("pandas", "to_pandas").DataFrame(
        {name: values for name, (values, _) in columns.items()}
    )
    frame.attrs["units"] = {name: unit for name, (_, unit) in columns.items()}
    return frame


def table_of(records: Iterable[Record]) -> "DataFrame":
    """Return a table of records, one row for each: resonances, critical speeds, limit checks...

    Parameters
    ----------
    records : iterable of records
        All of one kind, each with a method ``row()``.

    Returns
    -------
    pandas.DataFrame
        In SI, with the units in ``frame.attrs["units"]``, by column; empty if there are no records. Where
        they differ, a column "unit" of the records tells.

    Raises
    ------
    MissingLibraryError
        If pandas is not installed.

    Examples
    --------
    >>> class Found:
    ...     def row(self):
    ...         return {"order": (3.0, "1"), "speed": (52.0, "rad/s")}
    >>> frame = table_of([Found(), Found()])
    >>> len(frame), frame.attrs["units"]["speed"]
    (2, 'rad/s')
    """
    rows = [record.row() for record in records]
    columns = {}
    for name in rows[0] if rows else ():
        cells, units = zip(*(row[name] for row in rows), strict=True)
        columns[name] = (cells, units[0] if len(set(units)) == 1 else "SI, see the column unit")
    frame: DataFrame = table(columns)
    return frame


def grid(
    variables: Mapping[str, tuple[Any, Any, str, str]],
    coordinates: Mapping[str, tuple[Any, str, str]],
) -> Any:
    """Return an xarray dataset of arrays over named coordinates, with their units.

    Parameters
    ----------
    variables : mapping of str to tuple
        Of each array: names of its dimensions, values, unit, name in words.
    coordinates : mapping of str to tuple
        Of each coordinate: its values (one dimension of the same name), unit, name in words.

    Returns
    -------
    xarray.Dataset
        ``attrs["units"]`` and ``attrs["long_name"]`` of every array and coordinate describe it.
        All arrays are copies: changes of the dataset do not affect the result.

    Raises
    ------
    MissingLibraryError
        If xarray is not installed.

    Examples
    --------
    >>> found = grid(
    ...     {"twist": (("speed",), [0.1, 0.2], "rad", "twist of the free end")},
    ...     {"speed": ([10.0, 20.0], "rad/s", "shaft speed")},
    ... )
    >>> float(found.twist.sel(speed=20.0)), found.twist.attrs["units"]
    (0.2, 'rad')
    """
    return _load("xarray", "to_xarray").Dataset(
        {
            name: (dimensions, np.array(values), _attributes(unit, words))
            for name, (dimensions, values, unit, words) in variables.items()
        },
        coords={
            name: ((name,), np.array(values), _attributes(unit, words))
            for name, (values, unit, words) in coordinates.items()
        },
    )


def _attributes(unit: str, words: str) -> dict[str, str]:
    return {"units": unit, "long_name": words}


def _load(name: str, needed_by: str) -> Any:
    try:
        return import_module(name)
    except ModuleNotFoundError as error:
        if error.name != name:
            raise
        raise MissingLibraryError(
            f"{needed_by} needs the package {name}, which is not installed: "
            "pip install 'crankfem[frames]'"
        ) from None
