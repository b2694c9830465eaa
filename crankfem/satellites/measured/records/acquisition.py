"""Records of data acquisition systems: TDMS by npTDMS, MDF 4 by asammdf, and UFF 58 by pyuff."""

import math
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from crankbase.array_checks import Array
from crankbase.errors import InputError
from crankfem.satellites.measured.records.record import Channel, Column, Record
from crankfem.satellites.measured.records.series import (
    RecordReading,
    Series,
    at_steps,
    channels_of_series,
    named_channel,
    over_places,
)
from crankfem.satellites.measured.records.units import axis_of, read_unit

# Synchronization of a master channel in ASAM MDF 4, with the unit that the standard asks for.
SYNCHRONIZED = {1: ("time", "s"), 2: ("crank angle", "rad")}
# Types of numbers, and conversions that give numbers, in ASAM MDF 4.
NUMBERS, NUMBERS_CONVERTED = range(6), range(7)
# Data type of an abscissa that is a time in UFF 58, and functions over it; none of a text is "NONE".
UFF_TIME, UFF_FUNCTIONS = 17, (0, 1)
# Digits behind the first one of its places, and of values in single precision.
UFF_DIGITS = 5


def read_tdms(path: Path, reading: RecordReading) -> Record:
    """Read a record of LabVIEW: each channel at its own start, by `wf_start_time` and `wf_start_offset`."""
    from nptdms import TdmsFile

    channels: list[Channel] = []
    notes: list[str] = []
    with TdmsFile.read_metadata(path, raw_timestamps=True) as file:
        groups = [(group.name, group.channels()) for group in file.groups()]
        if file.file_status.incomplete_final_segment:
            notes.append(
                "The file ends within its last segment, as if writing had been interrupted."
            )
    begins = [
        each.properties["wf_start_time"]
        for _, of_group in groups
        for each in of_group
        if "wf_start_time" in each.properties and len(each)
    ]
    first = min(begins, key=lambda moment: (moment.seconds, moment.second_fractions), default=None)
    for group, of_group in groups:
        series = []
        for each in of_group:
            facts = each.properties
            if each.dtype.kind not in "iufb" or not len(each):
                notes.append(f"{each.name}: holds no numbers.")
                continue
            unit = str(facts.get("unit_string") or facts.get("NI_UnitDescription") or "")
            if facts.get("NI_Scaling_Status") == "unscaled" and not facts.get(
                "NI_Number_Of_Scales"
            ):
                notes.append(
                    f"{each.name}: holds raw numbers, which the file does not scale; their unit is unknown."
                )
                unit = ""
            one = Series(each.name, unit, _tdms_column(path, group, each.name, len(each)))
            step = float(facts.get("wf_increment", 0.0))
            if step <= 0.0:
                series.append(one)
                continue
            start = float(facts.get("wf_start_offset", 0.0))
            if first is not None and "wf_start_time" in facts:
                start += _seconds(facts["wf_start_time"], first)
            axis = facts.get("wf_xname") or "time", facts.get("wf_xunit_string") or "s"
            channels.append(
                even_channel(str(path), group, one, axis, start, step, 0.0, reading, notes)
            )
        more, of_series = channels_of_series(str(path), group, series, reading)
        channels += more
        notes += of_series
    return Record(str(path), "TDMS", tuple(channels), tuple(dict.fromkeys(notes)))


def _seconds(moment: Any, first: Any) -> float:
    """Return the time of a TDMS time stamp after another one [s]; their fractions are of 2^-64 s."""
    fractions = int(moment.second_fractions) - int(first.second_fractions)
    return float(int(moment.seconds) - int(first.seconds) + fractions * 2.0**-64)


def _tdms_column(path: Path, group: str, name: str, count: int) -> Column:
    from nptdms import TdmsFile

    def pieces(samples: int) -> Iterator[Array]:
        with TdmsFile.open(path) as file:
            channel = file[group][name]
            for first in range(0, count, samples):
                yield np.asarray(channel[first : first + samples], dtype=np.float64)

    return Column(count, pieces)


def even_channel(
    path: str,
    group: str,
    series: Series,
    axis: tuple[str, str],
    start: float,
    step: float,
    error: float,
    reading: RecordReading,
    notes: list[str],
) -> Channel:
    """Return a channel of which the file has start and step, in the unit of `axis` (its name and unit)."""
    name, unit = axis
    kind = axis_of(name, unit)
    channel = named_channel(group, series, reading, notes)
    if kind == "none":
        notes.append(f"{channel.name}: is over {name} [{unit}], neither time nor crank angle.")
        return channel
    unit = read_unit(reading.units.get(name, unit))[0]
    placed = Channel(
        channel.name, group, channel.unit, channel.column, kind, unit, start, step, None, error,
        channel.reference,
    )  # fmt: skip
    return at_steps(path, placed, reading, notes)


def read_mdf(path: Path, reading: RecordReading) -> Record:
    """Read a record in ASAM MDF: each channel over the master of its own group, time or angle."""
    from asammdf import MDF

    channels: list[Channel] = []
    notes: list[str] = []
    # asammdf finishes a file in a copy, by its path alone; of an opened one it reads channels in pieces.
    opened = path.open("rb")
    file = MDF(path if opened.read(5) == b"UnFin" else opened)
    if not file.version.startswith("4"):
        raise InputError(
            f"{path}: is MDF {file.version}; allowed is MDF 4, to which asammdf converts it."
        )
    for number, group in enumerate(file.groups):
        master = file.masters_db.get(number)
        name = group.channel_group.acq_name or f"group {number + 1}"
        if name in {each.group for each in channels}:
            name = f"{name} ({number + 1})"
        axis = None
        if master is not None:
            kind = group.channels[master]
            if kind.sync_type not in SYNCHRONIZED:
                notes.append(f"{kind.name}: is neither time nor angle.")
            else:
                word, unit = SYNCHRONIZED[kind.sync_type]
                axis = Series(word, kind.unit or unit, _mdf_column(file, number, master))
        gaps = group.channel_group.invalidation_bytes_nr > 0
        for place, each in enumerate(group.channels):
            if place == master:
                continue
            converted = (
                each.conversion is None or each.conversion.conversion_type in NUMBERS_CONVERTED
            )
            if each.data_type not in NUMBERS or not converted or group.channel_dependencies[place]:
                notes.append(f"{each.name}: holds no numbers.")
                continue
            unit = each.unit or (each.conversion.unit if each.conversion else "")
            series = Series(each.name, unit, _mdf_column(file, number, place), gaps=gaps)
            channel = named_channel(name, series, reading, notes)
            if axis is not None:
                named = axis.heading, read_unit(reading.units.get(axis.heading, axis.unit))[0]
                channel = over_places(str(path), channel, named, axis, reading, notes, gaps)
            channels.append(channel)
    return Record(str(path), "MDF", tuple(channels), tuple(dict.fromkeys(notes)))


def _mdf_column(file: Any, group: int, place: int) -> Column:
    """Return a channel of the file, which stays open; samples that it marks as invalid are NaN."""
    count = int(file.groups[group].channel_group.cycles_nr)

    def pieces(samples: int) -> Iterator[Array]:
        for first in range(0, count, samples):
            values, invalid = file.get(
                group=group, index=place, samples_only=True, ignore_invalidation_bits=True,
                record_offset=first, record_count=min(samples, count - first),
            )  # fmt: skip
            numbers = np.asarray(values, dtype=np.float64)
            yield numbers if invalid is None else np.where(invalid, math.nan, numbers)

    return Column(count, pieces)


def read_uff(path: Path, reading: RecordReading) -> Record:
    """Read functions over time in a universal file (type 58): places have six digits in it, unless binary."""
    import pyuff

    read: Any = pyuff.UFF(str(path)).read_sets()
    channels: list[Channel] = []
    notes: list[str] = []
    for number, each in enumerate([read] if isinstance(read, dict) else read, start=1):
        if each.get("type") != 58 or np.iscomplexobj(each["data"]):
            notes.append(f"Set {number}: is no function of real numbers (type 58).")
            continue
        of_time = each["abscissa_spec_data_type"] == UFF_TIME or (
            each["func_type"] in UFF_FUNCTIONS and not each["abscissa_spec_data_type"]
        )
        label, unit = (_labeled(each, f"abscissa_axis_{part}") for part in ("lab", "units_lab"))
        axis = (label, unit) if axis_of(label, unit) != "none" else ("time", unit or "s")
        if not of_time and axis_of(label, unit) == "none":
            notes.append(f"Set {number}: is no function of time or crank angle.")
            continue
        name = _labeled(each, "id1") or _labeled(each, "ordinate_axis_lab") or f"set {number}"
        count = int(each["num_pts"])
        values = np.asarray(each["data"], dtype=np.float64)
        if values.size != count:
            raise InputError(
                f"{path}: {name}: has {values.size} numbers and a header of {count}, as if it were "
                "damaged, or of another precision."
            )
        series = Series(name, _labeled(each, "ordinate_axis_units_lab"), Column.of(values))
        group = f"set {number}"
        if not each["binary"] and each["ord_data_type"] == 2:
            notes.append(f"{name}: its values have six digits.")
        if each["abscissa_spacing"]:
            start, step = float(each["abscissa_min"]), float(each["abscissa_inc"])
            error = _half_digit(start) + _half_digit(step) * (values.size - 1)
            channels.append(
                even_channel(str(path), group, series, axis, start, step, error, reading, notes)
            )
            continue
        places = np.asarray(each["x"], dtype=np.float64)
        largest = float(np.max(np.abs(places), initial=0.0))
        error = _half_digit(largest)
        if each["binary"]:
            error = largest * float(np.finfo(np.float32).eps) * (each["ord_data_type"] == 2) / 2.0
        channel = named_channel(group, series, reading, notes)
        named = axis[0], read_unit(reading.units.get(axis[0], axis[1]))[0]
        over = Series(axis[0], axis[1], Column.of(places), error)
        channels.append(over_places(str(path), channel, named, over, reading, notes))
    return Record(str(path), "UFF 58", tuple(channels), tuple(dict.fromkeys(notes)))


def _labeled(each: Mapping[str, Any], field: str) -> str:
    text = str(each.get(field, "")).strip()
    return "" if text.upper() == "NONE" else text


def _half_digit(number: float) -> float:
    """Return half of the last digit of a number that is printed with six."""
    if number == 0.0:
        return 0.0
    return 0.5 * 10.0 ** (math.floor(math.log10(abs(number))) - UFF_DIGITS)
