"""Limits of input sizes: far above ordinary input, far below what takes minutes."""

from pathlib import Path

from crankbase.errors import InputError
from crankbase.wrong_files import not_a_file

# Characters of a quantity such as "7850 kg/m^3", and of an expression of a study.
LONGEST_QUANTITY = 200
LONGEST_EXPRESSION = 1000
# Of all exponents in a unit or an expression, multiplied: m^4 kg^2 s^2 has 16.
LARGEST_POWER = 1000.0
# Bytes of an input file in TOML or of the text of a chain, and of a table or a model.
LARGEST_TEXT_FILE = 1_000_000
LARGEST_TABLE_FILE = 50_000_000
# Values in a TOML file, names in a dotted key or tables in tables, and characters of one name or text.
MOST_VALUES = 10_000
DEEPEST_TABLE = 30
LONGEST_TEXT = 10_000
# TOML guarantees integers of 64 bits, one of them the sign.
MOST_BITS = 63


def check_file_size(path: Path, most: int, what: str) -> None:
    """Refuse what is no file, or too large for its purpose, before it is read.

    Parameters
    ----------
    path : Path
        A file that cannot be examined is left to the reader.
    most : int
        Bytes.
    what : str
        Purpose of the file, for the message.

    Raises
    ------
    InputError
    """
    if (entry := not_a_file(path)) is not None:
        raise InputError(f"{path}: {entry}.")
    try:
        check_size(path, path.stat().st_size, most, what)
    except OSError:
        return


def check_size(path: Path, size: int, most: int, what: str) -> None:
    """Refuse a size [bytes] of a file's content; the rest as `check_file_size`."""
    if size > most:
        raise InputError(
            f"{path}: given a file of {size / 1e6:.3g} MB; allowed is {most / 1e6:g} MB at most, because "
            f"{what} has far less."
        )
