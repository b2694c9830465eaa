"""Reading a record: which format a file has, by its first bytes, and the library that reads it."""

from collections.abc import Callable, Mapping
from importlib import import_module
from pathlib import Path

from crankbase.array_checks import positive_number
from crankbase.errors import InputError, MissingLibraryError, shortened
from crankbase.input_file import not_a_file
from crankfem.satellites.measured.records.builder import RecordReading
from crankfem.satellites.measured.records.record import Record
from crankfem.satellites.measured.records.text import read_text

Reader = Callable[[Path, RecordReading], Record]
_HERE = __name__.rpartition(".")[0]
# First bytes of a format: its name, the package that reads it, and the function here.
FORMATS = {
    b"TDSm": ("TDMS", "nptdms", "acquisition:read_tdms"),
    b"MDF ": ("MDF 4", "asammdf", "acquisition:read_mdf"),
    b"UnFinMF": ("MDF 4", "asammdf", "acquisition:read_mdf"),
    b"    -1": ("UFF 58", "pyuff", "acquisition:read_uff"),
    b"MATLAB 5": ("MAT 5", "scipy", "nested:read_mat5"),
    b"MATLAB 7.3": ("MAT 7.3", "h5py", "nested:read_hdf5"),
    b"\x89HDF": ("HDF5", "h5py", "nested:read_hdf5"),
    b"PAR1": ("Parquet", "pyarrow", "parquet:read_parquet"),
}


def read_record(
    path: str | Path,
    *,
    columns: Mapping[str, int | str] | None = None,
    units: Mapping[str, str] | None = None,
    rate: float | None = None,
) -> Record:
    """Read a record that an instrument wrote.

    Parameters
    ----------
    columns : mapping of str to int or str, optional
        Name, which ends in its unit, of columns of a text without a usable header, by number from 1 or
        heading: ``{"time_s": 1, "wheel_V": 3}``.
    units : mapping of str to str, optional
        Units of channels, times and angles by name, in place of those in the file.
    rate : float, optional
        Samples in a second [1/s], where the file has no time, or too few digits of it.

    Returns
    -------
    Record
        Its format is found by the content.

    Raises
    ------
    InputError
        If the file cannot be read, or contradicts what is said of it.
    MissingLibraryError
        If the package that reads its format is not installed.
    """
    file = Path(path)
    if not file.is_file():
        what = not_a_file(file) or "does not exist"
        raise InputError(f"{path}: {what}; allowed is the path of a record.")
    if rate is not None:
        positive_number("rate", rate, "1/s", "it is a number of samples in a second")
    reading = RecordReading(columns or {}, units or {}, rate)
    with file.open("rb") as opened:
        head = opened.read(1024)
    for first, (name, package, function) in FORMATS.items():
        if head.startswith(first):
            record = _read(_reader(file, name, package, function), file, name, reading)
            break
    else:
        record = _read(read_text, file, "text", reading)
    if not record.channels:
        raise InputError(f"{path}: holds no channels of numbers; allowed is a record with some.")
    return record


def _read(reader: Reader, file: Path, name: str, reading: RecordReading) -> Record:
    """Read a record by the package of its format, which tells of damage by errors of many kinds."""
    try:
        return reader(file, reading)
    except InputError:
        raise
    except Exception as error:
        why = shortened(str(error)) or type(error).__name__
        raise InputError(f"{file}: cannot be read as {name} ({why}).") from None


def _reader(file: Path, name: str, package: str, function: str) -> Reader:
    """Load the reader of a format.

    Raises
    ------
    MissingLibraryError
        If its package is not installed.
    """
    module, _, function = function.partition(":")
    try:
        import_module(package)
    except ModuleNotFoundError:
        raise MissingLibraryError(
            f"{file}: is a record in {name}, which needs the package {package}: pip install "
            "'crankfem[measured]'."
        ) from None
    reader: Reader = getattr(import_module(f"{_HERE}.{module}"), function)
    return reader
