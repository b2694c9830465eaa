"""Input files and the files that they may name: on disk, sent, or shipped."""

import os
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

from crankbase.choices import did_you_mean
from crankbase.errors import InputError, quoted
from crankbase.input_file import InputFile, not_a_file
from crankfem.files.satellites import satellite_files

# By path, text and content of the files that a command has read.
FILES_READ: ContextVar[dict[Path, tuple[str, dict[str, Any]]] | None] = ContextVar(
    "read", default=None
)


@contextmanager
def each_file_once() -> Iterator[None]:
    """Read no file twice in this context: all that a command takes from one is of one state of it."""
    token = FILES_READ.set({})
    try:
        yield
    finally:
        FILES_READ.reset(token)


def data_folder() -> Path:
    """Return the folder of shipped data."""
    here = Path(__file__).resolve().parents[2]
    inside = here / "data"
    return inside if inside.is_dir() else here.parent / "data"


def input_kinds() -> tuple[str, ...]:
    """Return the kinds of input of which files are shipped."""
    return ("engine", *satellite_files(), "chain")


def shipped_names(*kinds: str) -> tuple[str, ...]:
    """Return the names of the shipped files of some kinds, or of all."""
    return tuple(
        name
        for kind in kinds or input_kinds()
        for name in sorted(path.stem for path in (data_folder() / f"{kind}s").glob("*.toml"))
    )


def shipped_torques() -> tuple[str, ...]:
    """Return the names of the shipped torque tables."""
    return tuple(sorted(path.name for path in (data_folder() / "tables").glob("*torque*.csv")))


def input_path(file: str | Path, kind: str = "engine") -> Path:
    """Find a file of input by path, or a shipped one by name."""
    if not isinstance(file, (str, os.PathLike)):
        raise InputError(
            f"file: given {quoted(file)}; allowed is the path of {_called(kind)}, or the name of a shipped "
            "one."
        )
    path = Path(file)
    try:
        if path.is_file():
            return path
        shipped = data_folder() / f"{kind}s" / f"{path.name.removesuffix('.toml')}.toml"
        if path.parent == Path() and shipped.is_file():
            return shipped
        fault = f"{file}: {not_a_file(path) or 'does not exist'}"
    except OSError as error:
        fault = f"{file}: cannot be searched for; the system reports: {error.strerror}"
    others = [
        folder_kind
        for folder_kind in input_kinds()
        if folder_kind != kind and path.name in shipped_names(folder_kind)
    ]
    if others:
        fault = f"{file}: is {_called(others[0]).removesuffix(' file')}, not {_called(kind)}"
    if not str(file).strip():
        fault = '"": names no file'
    meant = did_you_mean(path.name.removesuffix(".toml"), shipped_names(kind), cutoff=0.7)
    raise InputError(
        f"{fault}; {meant}give the path of {_called(kind)}, or the name of a shipped one "
        f"({', '.join(shipped_names(kind))})."
    )


def _called(kind: str) -> str:
    """How a message calls a file of this kind."""
    return f"{'an' if kind == 'engine' else 'a'} {kind} file"


def torque_path(file: str | Path) -> Path:
    """Find a torque table by path, or a shipped one by the name of its file."""
    path = Path(file)
    shipped = data_folder() / "tables" / path.name
    if path.is_file() or path.parent != Path() or path.name not in shipped_torques():
        return path
    return shipped


@dataclass(frozen=True)
class InputFiles:
    """An input file and those that its fields may name: whatever reads these asks here.

    Attributes
    ----------
    path : Path
        The input file.
    sent : mapping, optional
        Name to content of the files that were sent, the input file among them. No other is opened then
        but shipped ones. Without it, files are on disk, in the folder of the input file.
    """

    path: Path
    sent: Mapping[str, bytes] | None = None

    @property
    def main(self) -> InputFile:
        """The input file itself."""
        return InputFile(self.path, None if self.sent is None else self.sent[str(self.path)])

    def named(
        self, field: str, name: str, shipped: Literal["tables", "chains", ""] = ""
    ) -> InputFile:
        """Return the file that a field names.

        Parameters
        ----------
        field : str
            For the message.
        name : str
            Of the file, or of one among those of this kind that are `shipped`.
        """
        sent = self.sent
        if sent is None:
            path = self.path.parent / name
            if os.path.isfile(path):  # False for what is no path, too
                return InputFile(path)
            if (entry := not_a_file(path)) is not None:
                raise InputError(f"{field}: given {name!r}, which {entry}.")
        elif name in sent:
            return InputFile(Path(name), sent[name])
        for path in (data_folder() / shipped).iterdir() if shipped else ():
            if name in (path.name, path.name.removesuffix(".toml")):
                content = None if sent is None else path.read_bytes()
                return InputFile(path if sent is None else Path(path.name), content)
        where = "in the folder of" if sent is None else "among the files sent with"
        also = f"not {where} {self.path.name}"
        if shipped:
            known = f" ({', '.join(shipped_names('chain'))})" if shipped == "chains" else ""
            also = (
                f"neither {where} {self.path.name} nor a shipped {shipped.removesuffix('s')}{known}"
            )
        raise InputError(f"{field}: given {name!r}, which is {also}.")
