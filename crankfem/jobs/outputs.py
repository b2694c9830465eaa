"""Checks of the files that a command will write, before anything is computed; tables as CSV."""

import csv
import tempfile
from collections.abc import Iterable, Sequence
from itertools import combinations
from pathlib import Path

from crankbase.errors import InputError
from crankbase.outputs import Kind, Recognized, atomic_file, check_output, protect, protected


def check_writable(
    file: Path, kind: Kind, *inputs: Path, name: str = "", recognized: Recognized | None = None
) -> None:
    """Refuse a file that cannot or must not be written.

    Parameters
    ----------
    kind : str
        What is to be written, as `crankbase.outputs.check_output` has it.
    *inputs : Path
        Files that the command reads; nothing that it writes takes their place.
    name : str, optional
        What a message calls the file; its path by default.
    recognized : callable, optional
        As for `crankbase.outputs.check_output`.
    """
    protect(*inputs)
    with protected(*inputs):
        check_output(file, kind, recognized=recognized, name=name)
    if not file.absolute().parent.is_dir():
        raise InputError(f"{name or file}: cannot be written; there is no folder {file.parent}.")


def check_distinct_files(files: dict[str, Path | None]) -> None:
    """Refuse one file for two outputs.

    Parameters
    ----------
    files : dict
        Option to file, None where it is not given.
    """
    outputs = [(option, file.resolve()) for option, file in files.items() if file is not None]
    for (first, file), (second, other) in combinations(outputs, 2):
        if file == other:
            raise InputError(
                f"{second}: given {files[second]}, which {first} writes too; allowed is another file, "
                "because one would replace the other."
            )


def check_outputs(
    csv: Path | None, pictures: str | None, *inputs: Path, names: Iterable[str] = ()
) -> Path | None:
    """Refuse impossible outputs of --csv and --pictures before anything is computed for them.

    Parameters
    ----------
    pictures : str or None
        As it stands on the command line.
    *inputs : Path
        Files that the command reads.
    names : iterable of str
        Of the pictures.

    Returns
    -------
    Path or None
        The folder of the pictures, which is made if it is not there.
    """
    protect(*inputs)
    if csv is not None:
        check_writable(csv, "table", *inputs, name=f"--csv {csv}")
    return make_output_folder("--pictures", pictures, names)


def make_output_folder(
    option: str, path_given: str | Path | None, names: Iterable[str], kind: Kind = "picture"
) -> Path | None:
    """Make the folder that an option names, and refuse files that cannot be written there.

    Parameters
    ----------
    path_given : str, Path or None
        As it stands on the command line.
    names : iterable of str
        Of the files that are to be written into it.
    kind : str
        What these are, as `crankbase.outputs.check_output` has it.

    Returns
    -------
    Path or None
        None where the option is not given.
    """
    if path_given is None:
        return None
    if not str(path_given).strip():
        raise InputError(
            f'{option}: given ""; allowed is a folder, because {kind}s are files in it.'
        )
    folder = Path(path_given)
    system = "the system reports:"
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        reason = f"{system} {error.strerror or error}"
        if isinstance(error, FileExistsError | NotADirectoryError):
            reason = "a file of that name exists"
        raise InputError(
            f"{option} {path_given}: cannot be made a folder, because {reason}."
        ) from None
    try:
        # Rights alone do not tell what a file system takes.
        with tempfile.TemporaryFile(dir=folder):
            pass
    except OSError as error:
        raise InputError(
            f"{option} {path_given}: files cannot be written there, because {system} "
            f"{error.strerror or error}."
        ) from None
    for name in names:
        check_output(folder / name, kind)
    return folder


def write_rows(
    path: Path, names: Sequence[str], rows: Iterable[Sequence[object]], heading: str = ""
) -> None:
    """Write rows below the names of their columns.

    Parameters
    ----------
    heading : str, optional
        Content of the first line after a number sign; no such line if empty.
    """
    with atomic_file(path, "table") as part, part.open("w", encoding="utf-8", newline="") as file:
        if heading:
            file.write(f"# {heading}\n")
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(names)
        writer.writerows(rows)
