"""The chains of the shaft line behind the flywheel, from the files that its section names."""

from collections.abc import Sequence
from dataclasses import replace

from crankbase.errors import InputError
from crankfem.files.chain.chain_file import load_chain
from crankfem.files.reading.toml_file import TomlFile
from crankfem.files.sections.vibration_sections import ShaftLineFiles
from dynamics.chains.chain import Chain
from dynamics.chains.engine_chains import EngineChain, throw_names

# The key of a whole plant's chain, as its maker gives it.
PLANT = "plant"


def read_shaft_lines(content: TomlFile) -> dict[str, Chain]:
    """Read the chains that the section [shaft_line] of an engine file names, by their kind.

    Their values are listed with those of the engine file.

    Raises
    ------
    InputError
        Also if one is of the wrong kind.
    """
    given = content.model("shaft_line", ShaftLineFiles)
    found: dict[str, Chain] = {}
    for field, kind in (("torsional", "torsional"), ("axial", "axial"), (PLANT, "torsional")):
        name = None if given is None else getattr(given, field)
        if name is None:
            continue
        read = load_chain(content.files.named(f"shaft_line.{field}", name, "chains"))
        if read.kind != kind:
            why = "replaces" if field == PLANT else "continues"
            raise InputError(
                f"shaft_line.{field}: given {name!r}, a chain of kind {read.kind}; allowed is one of kind "
                f"{kind}, because it {why} that chain of the engine."
            )
        found[field] = read.chain
        content.records.extend(
            replace(one, field=f"shaft_line.{field}: {one.field}") for one in read.records
        )
    return found


def plant_chain(plant: Chain, cylinders: Sequence[int]) -> EngineChain:
    """Return the chain of a plant that its maker gives, with the nodes of its cranks.

    Parameters
    ----------
    plant : Chain
    cylinders : sequence of int
        Number of cylinders on each throw, from the free end.

    Raises
    ------
    InputError
        If cranks are missing, or the crankshaft is not a row from the first node to behind the last crank.
    """
    wanted = throw_names(cylinders, len(cylinders))
    missing = [name for name in wanted if name not in plant.names]
    if missing:
        raise InputError(
            f"shaft_line.plant: given a chain without {missing[0]!r}; allowed is one with the nodes "
            f"{', '.join(wanted)}, because the cylinders act on them."
        )
    further = f"{wanted[0].rpartition(' ')[0]} {len(wanted) + 1}"
    if further in plant.names:
        raise InputError(
            f"shaft_line.plant: given a chain with {further!r}; allowed is one with {len(wanted)} cranks, "
            "because the engine has so many."
        )
    nodes = tuple(plant.names.index(name) for name in wanted)
    row = tuple((node, node + 1) for node in range(nodes[-1] + 1))
    cranks = tuple(range(nodes[0], nodes[0] + len(nodes)))
    if nodes != cranks or plant.connections[: len(row)] != row:
        raise InputError(
            "shaft_line.plant: given cranks that do not follow each other; allowed is a chain that begins "
            "at the free end, its first elements in a row to behind the last crank, because these are the "
            "crankshaft."
        )
    return EngineChain(plant, "torsional", throw_nodes=nodes)
