"""Read chain files: nodes, elements, gears and dampers in TOML, or plain text."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from crankbase.errors import InputError
from crankbase.input_file import LARGEST_TEXT_FILE, InputFile
from crankbase.summaries import summarized
from crankfem.files.chain.chain_build import Section, chain_of
from crankfem.files.chain.chain_sections import AxialChainSection, TorsionalChainSection
from crankfem.files.chain.chain_text import read_chain_text
from crankfem.files.reading.data_files import InputFiles, input_path
from crankfem.files.reading.toml_file import InputRecord, TomlFile, read_toml
from dynamics.chains.chain import Chain
from dynamics.chains.shaft_line import Motion
from fem.material import STEEL, Material

# Sizes within which all calculations keep their digits.
SMALLEST, LARGEST = 1e-20, 1e20
SIZES = ("inertia", "stiffness", "ground", "damping", "ground_damping", "distributed_inertia")

KINDS: dict[str, type[Section]] = {"torsional": TorsionalChainSection, "axial": AxialChainSection}


@summarized("name", "kind", "path", "chain.inertia", "chain.stiffness")
@dataclass(frozen=True)
class ChainFile:
    """A chain file, read and checked.

    Attributes
    ----------
    path : Path
    name : str
    kind : {"torsional", "axial"}
    chain : Chain
    records : tuple of InputRecord
        Every value with its source; empty for plain text, whose comments state it.
    sources : dict
        Short name to full citation.
    """

    path: Path
    name: str
    kind: Motion
    chain: Chain
    records: tuple[InputRecord, ...]
    sources: dict[str, str]


def load_chain(path: str | Path | InputFile | TomlFile) -> ChainFile:
    """Read and check a chain file.

    Parameters
    ----------
    path : path
        A TOML file, any other file as plain text, or the name of a shipped one; or the sections of a
        TOML file, if already read.

    Raises
    ------
    InputError
        With a sentence for each wrong field, which names what was given and what is allowed.
    """
    if isinstance(path, TomlFile):
        return _read_chain(path)
    file = path if isinstance(path, InputFile) else InputFile(input_path(path, "chain"))
    found = file.path
    if found.suffix.lower() != ".toml":
        allowed = "an input file (TOML) or the text of a chain"
        read = read_chain_text(
            file.text(LARGEST_TEXT_FILE, "the text of a chain", allowed), found.name
        )
        _check_sizes(found.name, read.chain)
        return ChainFile(found, read.name or found.stem, read.kind, read.chain, (), {})
    sent = None if file.sent is None else {str(found): file.sent}
    return _read_chain(read_toml(InputFiles(found, sent)))


def _read_chain(content: TomlFile) -> ChainFile:
    found = content.path
    kind = content.sections.get("chain", {}).get("kind")
    known = isinstance(kind, str) and kind in KINDS
    with content.all_errors(
        {"material": Material} | ({"chain": KINDS[str(kind)]} if known else {})
    ):
        content.check_sections({"chain": True, "material": False})
        if not known:
            raise InputError(
                f"{found.name}: chain.kind: given {kind!r}; allowed are torsional and axial, because units "
                "follow from it."
            )
        section: Section = content.required("chain", KINDS[str(kind)])
        material = content.model("material", Material) or STEEL
    try:
        chain = chain_of(section, material)
    except InputError as error:
        raise InputError("\n".join(f"{found.name}: {one}" for one in error.sentences)) from None
    _check_sizes(found.name, chain)
    return ChainFile(
        found, section.name, section.kind, chain, tuple(content.records), content.sources
    )


def _check_sizes(file: str, chain: Chain) -> None:
    """Refuse numbers so small or large that their squares underflow or overflow.

    Raises
    ------
    InputError
    """
    sizes = {name: np.abs(getattr(chain, name)) for name in SIZES}
    sizes["dashpots"] = np.array([dashpot.damping for dashpot in chain.dashpots])
    sizes["gears"] = np.abs([gear.ratio for gear in chain.gears])
    for name, values in sizes.items():
        wrong = values[(values != 0.0) & ~((values >= SMALLEST) & (values <= LARGEST))]
        if wrong.size:
            raise InputError(
                f"{file}: {name}: given {wrong[0]:g}; allowed are sizes from {SMALLEST:g} to {LARGEST:g}, "
                "because no machine has others."
            )
