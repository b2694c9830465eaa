"""The chains of what follows the flywheel of an engine, from the files that its section names."""

from dataclasses import replace

from crankbase.errors import InputError
from crankfem.files.chain.chain_file import load_chain
from crankfem.files.reading.toml_file import TomlFile
from crankfem.files.sections.vibration_sections import ShaftLineFiles
from dynamics.chains.chain import Chain


def read_shaft_lines(content: TomlFile) -> dict[str, Chain]:
    """Read the chains that the section [shaft_line] of an engine file names, by their kind.

    Their values are noted beside those of the engine file.

    Raises
    ------
    InputError
        Also if one is of the other kind.
    """
    given = content.model("shaft_line", ShaftLineFiles)
    found: dict[str, Chain] = {}
    for kind in ("torsional", "axial"):
        name = None if given is None else getattr(given, kind)
        if name is None:
            continue
        beside = content.path.parent / name
        read = load_chain(beside if beside.is_file() else name)
        if read.kind != kind:
            raise InputError(
                f"shaft_line.{kind}: given {name!r}, a chain of kind {read.kind}; allowed is one of kind "
                f"{kind}, because it continues that chain of the engine."
            )
        found[kind] = read.chain
        content.records.extend(
            replace(one, field=f"shaft_line.{kind}: {one.field}") for one in read.records
        )
    return found
