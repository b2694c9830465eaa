"""Records in nested structures: MAT 5 by scipy, MAT 7.3 and HDF5 by h5py.

A structure holds vectors, numbers and texts, and further structures. Its times are a vector beside the
others, or above them, or start and rate among the numbers.
"""

from collections.abc import Iterator, Mapping
from contextlib import contextmanager, nullcontext
from dataclasses import dataclass, field, replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from crankbase.array_checks import Array
from crankfem.satellites.measured.records.builder import RecordBuilder, RecordReading, Series
from crankfem.satellites.measured.records.record import Column, Record
from crankfem.satellites.measured.records.units import axis_of, split_heading

# Names of numbers that tell the rate of samples [1/s], their step [s] and their start [s], in small letters
# and without "_"; and of those that would change the samples.
RATES = ("fs", "rate", "samplerate", "samplingrate", "samplefrequency", "samplingfrequency")
STEPS = ("dt", "step", "increment", "dx", "sampleinterval", "wfincrement")
STARTS = ("t0", "start", "startvalue", "wfstartoffset")
SCALES = ("scale", "scalefactor", "gain", "factor", "addoffset")
# Structures beside the one with the values that tell of their places.
AXES = ("x_values", "xvalues", "abscissa", "axis")
UNITS = ("unit", "units", "unitstring", "yunit")
# Names that say nothing of what is measured: the structure has the name.
PLAIN = ("values", "value", "data", "y", "samples", "y_values", "yvalues")
# More columns than so many are no channels.
MOST_COLUMNS = 256


@dataclass(frozen=True, eq=False)
class Structure:
    """A structure of a file.

    Attributes
    ----------
    path : tuple of str
        Names of the structures that it is in, and its own.
    vectors : list of Series
        By name.
    numbers, texts : mapping of str
        Their names in small letters and without "_".
    parts : list of Structure
        In it.
    """

    path: tuple[str, ...] = ()
    vectors: list[Series] = field(default_factory=list)
    numbers: dict[str, float] = field(default_factory=dict)
    texts: dict[str, str] = field(default_factory=dict)
    parts: "list[Structure]" = field(default_factory=list)


def _key(name: str) -> str:
    return name.casefold().replace("_", "")


def read_mat5(path: Path, reading: RecordReading) -> Record:
    """Read variables of Matlab up to version 7, which are in memory then."""
    from scipy.io import loadmat

    variables = loadmat(path, simplify_cells=True)
    top = Structure()
    for name, value in variables.items():
        if not name.startswith("__"):
            _add(top, name, value)
    builder = RecordBuilder(path, "MAT 5", reading)
    _collect(builder, top, {}, [])
    return builder.record


def _add(structure: Structure, name: str, value: Any) -> None:
    """Add a variable of Matlab to a structure."""
    if isinstance(value, str):
        structure.texts[_key(name)] = value
    elif isinstance(value, Mapping):
        part = Structure((*structure.path, name))
        for inner, content in value.items():
            _add(part, str(inner), content)
        structure.parts.append(part)
    elif isinstance(value, list) or (isinstance(value, np.ndarray) and value.dtype == object):
        for place, content in enumerate(np.ravel(np.asarray(value, dtype=object)), start=1):
            _add(structure, f"{name}({place})", content)
    elif np.size(value) == 1 and np.asarray(value).dtype.kind in "iufb":
        structure.numbers[_key(name)] = float(np.asarray(value).ravel()[0])
    elif np.asarray(value).dtype.kind in "iufb":
        array = np.squeeze(value)
        structure.vectors.extend(_columns_of(name, array, "", partial(nullcontext, array)))


def _columns_of(name: str, values: Any, unit: str, opened: Any) -> Iterator[Series]:
    """Return an array of one or two dimensions as columns; the longer dimension is that of samples.

    `opened` returns a context of the array, perhaps in its file.
    """
    shape = [size for size in values.shape if size != 1]
    if not 1 <= len(shape) <= 2 or min(shape[1:], default=1) > MOST_COLUMNS < shape[0]:
        return
    error, long = _single_error(values), int(np.argmax(values.shape))
    for place in range(1 if len(shape) == 1 else min(shape)):

        def at(array: Any, rows: slice, place: int = place) -> Any:
            parts = [place if size in shape else 0 for size in array.shape]
            return array[tuple(rows if axis == long else part for axis, part in enumerate(parts))]

        heading = name if len(shape) == 1 else f"{name}({place + 1})"
        yield Series(heading, unit, _stored(max(shape), opened, at), error)


def _single_error(values: Any) -> float:
    """Return the error of numbers in single precision, by the largest."""
    if values.dtype != np.float32 or not values.size:
        return 0.0
    last = np.asarray(values[(-1,) * values.ndim])
    return float(np.abs(last)) * float(np.finfo(np.float32).eps) / 2.0


def _stored(count: int, opened: Any, at: Any) -> Column:
    def pieces(samples: int) -> Iterator[Array]:
        with opened() as array:
            for first in range(0, count, samples):
                yield np.asarray(at(array, slice(first, first + samples)), dtype=np.float64)

    return Column(count, pieces)


def read_hdf5(path: Path, reading: RecordReading) -> Record:
    """Read HDF5, and variables of Matlab 7.3, which are turned over in it and refer to each other."""
    import h5py

    top = Structure()
    with h5py.File(path) as file:
        matlab = file.userblock_size > 0
        _add_attributes(top, file.attrs)
        for name, item in file.items():
            if not name.startswith("#"):
                _add_item(top, path, name, item)
    builder = RecordBuilder(path, "MAT 7.3" if matlab else "HDF5", reading)
    _collect(builder, top, {}, [])
    return builder.record


def _add_attributes(structure: Structure, attributes: Mapping[str, Any]) -> None:
    for name, value in attributes.items():
        if isinstance(value, bytes | str):
            text = value.decode(errors="replace") if isinstance(value, bytes) else value
            structure.texts[_key(name)] = text
        elif np.size(value) == 1 and np.asarray(value).dtype.kind in "iuf":
            structure.numbers[_key(name)] = float(np.ravel(value)[0])


def _add_item(structure: Structure, path: Path, name: str, item: Any) -> None:
    """Add a group or data set of HDF5 to a structure."""
    import h5py

    kind = item.attrs.get("MATLAB_class", b"")
    if isinstance(item, h5py.Group):
        part = Structure((*structure.path, name))
        _add_attributes(part, item.attrs)
        for inner, content in item.items():
            _add_item(part, path, inner, content)
        structure.parts.append(part)
    elif kind == b"char":
        structure.texts[_key(name)] = "".join(map(chr, np.ravel(item[()], order="F")))
    elif h5py.check_ref_dtype(item.dtype) is not None:
        for place, reference in enumerate(np.ravel(item[()]), start=1):
            if reference:
                _add_item(structure, path, f"{name}({place})", item.file[reference])
    elif h5py.check_string_dtype(item.dtype) is not None:
        if item.size == 1:
            structure.texts[_key(name)] = str(np.ravel(item.asstr()[()])[0])
    elif item.dtype.names:
        for inner in item.dtype.names:
            if item.dtype[inner].kind in "iufb" and item.ndim == 1:
                column = _stored(
                    item.size, _opened(path, item.name), lambda array, rows, inner=inner: array[inner, rows]
                )  # fmt: skip
                structure.vectors.append(Series(inner, "", column))
    elif item.dtype.kind in "iufb" and item.size == 1:
        structure.numbers[_key(name)] = float(np.ravel(item[()])[0])
    elif item.dtype.kind in "iufb" and not item.attrs.get("MATLAB_empty", 0):
        part = Structure((*structure.path, name))
        _add_attributes(part, item.attrs)
        unit = next((part.texts[key] for key in UNITS if key in part.texts), "")
        columns = [*_columns_of(name, item, unit, _opened(path, item.name))]
        if part.numbers.keys() & {*RATES, *STEPS, *SCALES}:
            part.vectors.extend(columns)
            structure.parts.append(part)
        else:
            structure.vectors.extend(columns)


def _opened(path: Path, name: str) -> Any:
    """Return what opens a data set of a file."""
    import h5py

    @contextmanager
    def opened() -> Iterator[Any]:
        with h5py.File(path) as file:
            yield file[name]

    return opened


def _collect(
    builder: RecordBuilder,
    structure: Structure,
    numbers: Mapping[str, float],
    axes: list[Series],
) -> None:
    """Add the channels of a structure and of those in it, with times that are above them."""
    beside = [part for part in structure.parts if part.path[-1].casefold() in AXES]
    numbers = dict(numbers) | structure.numbers
    for part in beside:
        numbers |= part.numbers
        axes = [*axes, *part.vectors]
    vectors = [_titled(structure, each) for each in structure.vectors]
    path = structure.path
    if vectors and structure.vectors[0].heading.casefold() in PLAIN:
        path = path[:-1]
    if vectors and structure.numbers.keys() & {*SCALES}:
        builder.notes.append(
            f"{'.'.join(structure.path)}: has a scale or offset, which is not applied."
        )
    rate = next((numbers[key] for key in RATES if key in numbers), 0.0)
    step = next((numbers[key] for key in STEPS if key in numbers), 1.0 / rate if rate else 0.0)
    start = next((numbers[key] for key in STARTS if key in numbers), 0.0)
    times = [each for each in vectors if axis_of(*split_heading(each.heading, each.unit)) != "none"]
    for count in sorted({each.column.count for each in vectors}):
        alike = [each for each in vectors if each.column.count == count]
        shared = [each for each in axes if each.column.count == count][:1]
        if any(each in times for each in alike):
            shared = []
        elif not shared and step > 0.0:
            for each in alike:
                builder.add_even(".".join(path), each, ("time", "s"), start, step)
            continue
        builder.add_columns(".".join(path), [*shared, *alike])
    for part in structure.parts:
        if part not in beside:
            _collect(builder, part, numbers, [*axes, *times])


def _titled(structure: Structure, each: Series) -> Series:
    """Return a vector with the name of its structure if its own says nothing, and with its unit."""
    name, texts = each.heading, dict(structure.texts)
    for part in structure.parts:
        if _key(part.path[-1]) in ("quantity", "units"):
            texts |= part.texts | {"unit": part.texts.get("label", "")}
    keys = [f"{_key(name)}unit", f"{_key(name)}units", _key(name)]
    if name.casefold() in PLAIN and structure.path:
        keys += UNITS
        named = [part for part in structure.path if part.casefold() not in PLAIN]
        name = structure.texts.get("name", named[-1] if named else name)
    unit = each.unit or next((texts[key] for key in keys if key in texts), "")
    return replace(each, heading=name, unit=unit)
