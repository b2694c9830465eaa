"""The satellites: parts that stand apart, each in a folder of its own, and the one place that names them.

A satellite's module `plug` has `PLUGS`, one for each of its commands, and imports nothing but this module:
what it names by place, "module:name" within `crankfem.satellites`, is loaded when it is asked for.
"""

from dataclasses import dataclass
from functools import cache
from importlib import import_module
from typing import Any

SATELLITES = ("hinge", "cad", "class_document", "service", "optimum", "measured")


def at_place(place: str, package: str = "crankfem.satellites") -> Any:
    """Return what is at a place, "module:name", the module perhaps relative to a package."""
    module, name = place.split(":")
    return getattr(import_module(module, package), name)


@dataclass(frozen=True)
class FilesOfInput:
    """Files that a satellite reads, another kind than engine and chain files.

    Attributes
    ----------
    kind : str
        Its name; shipped files are in the folder of `data` with this name and an s.
    about : str
        What such a file does, to follow its name in a sentence: "describes ...".
    command : str
        The name of the command that reads it.
    marks : frozenset of str
        Sections that tell such a file from others: it has one of these.
    reader : str
        Place of the function that reads a file, from its path or sections: `path`, `name` and `records`.
    sections : str
        Place of its sections in their order, name to model.
    """

    kind: str
    about: str
    command: str
    marks: frozenset[str]
    reader: str
    sections: str


@dataclass(frozen=True)
class UseOfEngines:
    """What the command of a satellite takes of engine files.

    Attributes
    ----------
    used : str
        Place of the function that returns what it uses of a file's sections, in a case, and what not, as
        `USES` of `crankfem.files.engine.used_values` has it.
    needs : frozenset of str
        Sections of which it needs one, beside those of a whole engine, where this file is enough for it.
    case : str
        Place of the function that names the case from the command's arguments, if there are several.
    """

    used: str
    needs: frozenset[str] = frozenset()
    case: str = ""


@dataclass(frozen=True)
class Plug:
    """What the core knows of a satellite, or of one of its commands.

    Attributes
    ----------
    command : str
        Place of the function of its command, with the name of the command. Its module is loaded for the help
        on all commands, and so loads nothing slow.
    after : str
        The command of the core after which it is listed, in the same group.
    examples : tuple of str
        Arguments that work in an empty folder.
    files : FilesOfInput or None
        Files of its own.
    engines : UseOfEngines or None
        What the command takes of engine files, if it reads some.
    """

    command: str
    after: str
    examples: tuple[str, ...]
    files: FilesOfInput | None = None
    engines: UseOfEngines | None = None


def called(place: str) -> str:
    """Return the name of a command by the place or the name of its function."""
    return place.rpartition(":")[2].strip("_").replace("_", "-")


@cache
def plugs() -> tuple[Plug, ...]:
    """Return the plugs of all satellites."""
    return tuple(plug for name in SATELLITES for plug in at_place(f".{name}.plug:PLUGS"))


@cache
def satellite_files() -> dict[str, FilesOfInput]:
    """Return the files that satellites read, by kind."""
    return {plug.files.kind: plug.files for plug in plugs() if plug.files}


@cache
def uses_of_satellites() -> dict[str, UseOfEngines]:
    """Return what commands of satellites take of engine files, by the command's name."""
    return {called(plug.command): plug.engines for plug in plugs() if plug.engines}
