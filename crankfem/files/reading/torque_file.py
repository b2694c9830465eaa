"""Read a torque table by path, or a shipped one by name."""

from pathlib import Path

from crankfem.files.reading.data_files import torque_path
from dynamics.harmonics import TorqueTable, read_torque_table


def load_torque_table(path: str | Path, *, strokes: int | None = None) -> TorqueTable:
    """Read the torque of one throw over a cycle; `read_torque_table` describes the format.

    Parameters
    ----------
    path : path
        The CSV file, or the name of a shipped one, such as ``yamz5340_torque_one_throw.csv``.
    strokes : int, optional
        Strokes per cycle, 2 or 4, if the table does not define it; 4 by default.

    Raises
    ------
    InputError
        With file and line, if the table cannot be used.
    """
    return read_torque_table(torque_path(path), strokes=strokes)
