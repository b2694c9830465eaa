"""What a command may write, found out before anything is computed for it."""

import tempfile
from itertools import combinations
from pathlib import Path

from crankbase.errors import InputError
from crankbase.outputs import Kind, Recognized, check_output, protect, protected


def check_writable(
    file: Path, kind: Kind, *inputs: Path, name: str = "", recognized: Recognized | None = None
) -> None:
    """Refuse a file that cannot or must not be written.

    Parameters
    ----------
    file : Path
    kind : str
        What is to be written, as `crankbase.outputs.check_output` has it.
    *inputs : Path
        Files that the command reads; nothing that it writes takes their place.
    name : str, optional
        What a message calls the file; its path by default.
    recognized : callable, optional
        As for `crankbase.outputs.check_output`.

    Raises
    ------
    InputError
        If it is a folder, in no folder, one of the inputs, or somebody else's.
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

    Raises
    ------
    InputError
    """
    given = [(option, file.resolve()) for option, file in files.items() if file is not None]
    for (first, file), (second, other) in combinations(given, 2):
        if file == other:
            raise InputError(
                f"{second}: given {files[second]}, which {first} writes too; allowed is another file, "
                "because one would take the place of the other."
            )


def check_outputs(csv: Path | None, pictures: str | None, *inputs: Path) -> Path | None:
    """Refuse outputs of --csv and --pictures that cannot be, before anything is computed for them.

    Parameters
    ----------
    csv : Path or None
    pictures : str or None
        As it stands on the command line.
    *inputs : Path
        Files that the command reads.

    Returns
    -------
    Path or None
        The folder of the pictures, which is made if it is not there.

    Raises
    ------
    InputError
        If `csv` is what `check_writable` refuses; if `pictures` is empty, a file stands in its way, or files
        cannot be written there.
    """
    protect(*inputs)
    if csv is not None:
        check_writable(csv, "table", *inputs, name=f"--csv {csv}")
    return None if pictures is None else _picture_folder(pictures)


def _picture_folder(text: str) -> Path:
    if not text.strip():
        raise InputError(
            '--pictures: given ""; allowed is a folder, because pictures are files in it.'
        )
    folder = Path(text)
    reason = None
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except (FileExistsError, NotADirectoryError):
        reason = "a file stands in its way"
    except OSError as error:
        reason = f"the system says: {error.strerror or error}"
    if reason is not None:
        raise InputError(f"--pictures {text}: cannot be made a folder, because {reason}.")
    try:
        # Rights alone do not tell what a file system takes.
        with tempfile.TemporaryFile(dir=folder):
            pass
    except OSError as error:
        raise InputError(
            f"--pictures {text}: files cannot be written there, because the system says: "
            f"{error.strerror or error}."
        ) from None
    return folder
