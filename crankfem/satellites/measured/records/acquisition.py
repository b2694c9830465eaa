"""Records of data acquisition systems: TDMS by npTDMS, MDF 4 by asammdf, and UFF 58 by pyuff."""

import math
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from crankbase.array_checks import Array
from crankbase.errors import InputError
from crankfem.satellites.measured.records.builder import RecordBuilder, RecordReading, Series
from crankfem.satellites.measured.records.record import Axis, Column, Record
from crankfem.satellites.measured.records.units import axis_of

# Synchronization of a master channel in ASAM MDF 4, with the unit that the standard asks for.
SYNCHRONIZED: dict[int, tuple[Axis, str]] = {1: ("time", "s"), 2: ("angle", "rad")}
# Types of numbers, and conversions that give numbers, in ASAM MDF 4.
NUMBERS, NUMBERS_CONVERTED = range(6), range(7)
# Data type of an abscissa that is a time in UFF 58, or unknown, and functions over it.
UFF_TIME, UFF_UNKNOWN, UFF_FUNCTIONS = 17, 0, (0, 1)
# Data type of values in single precision in UFF 58, and digits behind the first one of its places.
UFF_SINGLE, UFF_DIGITS = 2, 5


def read_tdms(path: Path, reading: RecordReading) -> Record:
    """Read a record of LabVIEW: each channel at its own start, by `wf_start_time` and `wf_start_offset`."""
    from nptdms import TdmsFile

    builder = RecordBuilder(path, "TDMS", reading)
    with TdmsFile.read_metadata(path, raw_timestamps=True) as file:
        groups = {group.name: group.channels() for group in file.groups()}
        if file.file_status.incomplete_final_segment:
            builder.notes.append("The file ends within its last segment, as if it was cut off.")
    begins = [
        each.properties["wf_start_time"]
        for channels in groups.values()
        for each in channels
        if "wf_start_time" in each.properties
    ]
    first: Any = min(
        begins, key=lambda moment: (moment.seconds, moment.second_fractions), default=None
    )
    for group, channels in groups.items():
        beside = []
        for channel in channels:
            facts = channel.properties
            if channel.dtype.kind not in "iufb" or not len(channel):
                builder.notes.append(f"{channel.name}: holds no numbers.")
                continue
            unit = str(facts.get("unit_string") or facts.get("NI_UnitDescription") or "")
            if facts.get("NI_Scaling_Status") == "unscaled" and not facts.get(
                "NI_Number_Of_Scales"
            ):
                builder.notes.append(
                    f"{channel.name}: holds raw numbers that the file does not scale; their unit is unknown."
                )
                unit = ""
            series = Series(
                channel.name, unit, _tdms_column(path, group, channel.name, len(channel))
            )
            step = float(facts.get("wf_increment", 0.0))
            if step <= 0.0:
                beside.append(series)
                continue
            start = float(facts.get("wf_start_offset", 0.0))
            if "wf_start_time" in facts:
                # Fractions of TDMS time stamps are of 2^-64 s.
                moment = facts["wf_start_time"]
                fractions = int(moment.second_fractions) - int(first.second_fractions)
                start += int(moment.seconds) - int(first.seconds) + fractions * 2.0**-64
            axis = facts.get("wf_xname") or "time", facts.get("wf_xunit_string") or "s"
            builder.add_even(group, series, axis, start, step)
        builder.add_columns(group, beside)
    return builder.record


def _tdms_column(path: Path, group: str, name: str, count: int) -> Column:
    from nptdms import TdmsFile

    def pieces(samples: int) -> Iterator[Array]:
        with TdmsFile.open(path) as file:
            channel = file[group][name]
            for first in range(0, count, samples):
                yield np.asarray(channel[first : first + samples], dtype=np.float64)

    return Column(count, pieces)


def read_mdf(path: Path, reading: RecordReading) -> Record:
    """Read a record in ASAM MDF: each channel over the master of its own group, time or angle."""
    from asammdf import MDF

    builder = RecordBuilder(path, "MDF", reading)
    # asammdf finishes a file in a copy, by its path alone; of an opened one it reads channels in pieces.
    opened = path.open("rb")
    file = MDF(path if opened.read(5) == b"UnFin" else opened)
    if not file.version.startswith("4"):
        raise InputError(
            f"{path}: is MDF {file.version}; allowed is MDF 4, to which asammdf converts it."
        )
    names: list[str] = []
    for number, group in enumerate(file.groups):
        name = group.channel_group.acq_name or f"group {number + 1}"
        names.append(f"{name} ({number + 1})" if name in names else name)
        place = file.masters_db.get(number)
        master = None if place is None else group.channels[place]
        over = None
        if master is not None and master.sync_type in SYNCHRONIZED:
            kind, unit = SYNCHRONIZED[master.sync_type]
            series = Series(master.name, master.unit or unit, _mdf_column(file, number, place))
            over = builder.places(series, kind)
        elif master is not None:
            builder.notes.append(f"{master.name}: is neither time nor angle.")
        gaps = group.channel_group.invalidation_bytes_nr > 0
        for index, channel in enumerate(group.channels):
            converted = channel.conversion is None or (
                channel.conversion.conversion_type in NUMBERS_CONVERTED
            )
            plain = channel.data_type in NUMBERS and not group.channel_dependencies[index]
            if index == place:
                continue
            if not plain or not converted:
                builder.notes.append(f"{channel.name}: holds no numbers.")
                continue
            unit = channel.unit or (channel.conversion.unit if channel.conversion else "")
            column = _mdf_column(file, number, index)
            builder.add_over(names[-1], Series(channel.name, unit, column, gaps=gaps), over)
    return builder.record


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

    builder = RecordBuilder(path, "UFF 58", reading)
    sets: Any = pyuff.UFF(str(path)).read_sets()
    for number, each in enumerate([sets] if isinstance(sets, dict) else sets, start=1):
        group = f"set {number}"
        if each.get("type") != 58 or np.iscomplexobj(each["data"]):
            builder.notes.append(f"{group}: is no function of real numbers (type 58).")
            continue
        label, unit = (_labeled(each, f"abscissa_axis_{part}") for part in ("lab", "units_lab"))
        kind, of = axis_of(label, unit), each["abscissa_spec_data_type"]
        if kind == "none":
            if of != UFF_TIME and (of != UFF_UNKNOWN or each["func_type"] not in UFF_FUNCTIONS):
                builder.notes.append(f"{group}: is no function of time or crank angle.")
                continue
            label, unit = "time", unit or "s"
        name = _labeled(each, "id1") or _labeled(each, "ordinate_axis_lab") or group
        values, count = np.asarray(each["data"], dtype=np.float64), int(each["num_pts"])
        if values.size != count:
            raise InputError(
                f"{path}: {name}: has {values.size} numbers and a header of {count}, as if it were damaged, "
                "or of another precision."
            )
        series = Series(name, _labeled(each, "ordinate_axis_units_lab"), Column.of(values))
        single = each["ord_data_type"] == UFF_SINGLE
        if single and not each["binary"]:
            builder.notes.append(f"{name}: its values have six digits.")
        if each["abscissa_spacing"]:
            start, step = float(each["abscissa_min"]), float(each["abscissa_inc"])
            error = _half_digit(start) + _half_digit(step) * (count - 1)
            builder.add_even(group, series, (label, unit), start, step, error)
            continue
        instants = np.asarray(each["x"], dtype=np.float64)
        largest = float(np.max(np.abs(instants), initial=0.0))
        error = largest * float(np.finfo(np.float32).eps) / 2.0 if single else 0.0
        error = error if each["binary"] else _half_digit(largest)
        builder.add_over(
            group, series, builder.places(Series(label, unit, Column.of(instants), error))
        )
    return builder.record


def _labeled(each: Mapping[str, Any], field: str) -> str:
    text = str(each.get(field, "")).strip()
    return "" if text.upper() == "NONE" else text


def _half_digit(number: float) -> float:
    """Return half of the last digit of a number that is printed with six."""
    if number == 0.0:
        return 0.0
    return 0.5 * 10.0 ** (math.floor(math.log10(abs(number))) - UFF_DIGITS)
