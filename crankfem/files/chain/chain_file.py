"""Read chain files: nodes, elements, gears and dampers in TOML, or plain text; shaft lines of engines."""

import math
import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np

from crankbase.array_checks import Array
from crankbase.choices import check_choice
from crankbase.errors import InputError, InputErrors
from crankbase.input_file import LARGEST_TEXT_FILE, InputFile
from crankbase.sentences import amount, joined, kept
from crankbase.summaries import frozen
from crankbase.written_quantity import parse_quantity
from crankfem.files.chain.chain_build import (
    KINDS,
    UNITS,
    chain_of,
    shaft_row,
)
from crankfem.files.chain.maker_values import as_printed
from crankfem.files.reading.data_files import InputFiles, input_path
from crankfem.files.reading.toml_file import InputRecord, TomlFile, read_toml
from crankfem.files.sections.vibration_sections import ASSUMED_PER_DIAMETER, ShaftLineFiles
from dynamics.chains.chain import Chain, Dashpot, Gear
from dynamics.chains.engine_chains import EngineChain, throw_names
from dynamics.chains.shaft_line import Motion, ShaftCone
from dynamics.crankshaft.line_beam import LineBeam
from fem.material import STEEL, Material

COLUMNS = re.compile(r"\s{2,}|\t+")
HEADING = re.compile(r"(torsional|axial)(?:\s+chain)?\s*(?::\s*(.*))?")
# "ground" alone is short for its stiffness.
NODE_WORDS = ("ground stiffness", "ground damping", "ground")
NODE_COLUMN = re.compile(r"(ground(?: stiffness| damping)?)\s+(?=[-+.\d])(.*)")
LINK_WORDS = ("inertia", "damping", "loss", "dashpot", "gear", "from", "to")


@frozen("name", "kind", "chain.inertia", "chain.stiffness")
class ChainText:
    """A chain read from text.

    Parameters
    ----------
    kind : {"torsional", "axial"}
    name : str
        Empty if none is given.
    chain : Chain
    """

    kind: Motion
    name: str
    chain: Chain


@dataclass
class _Link:
    """Content of one indented line."""

    line: str
    left: str | None
    right: str | None = None
    values: dict[str, float] = field(default_factory=dict)


def read_chain_text(text: str, source: str = "text") -> ChainText:
    """Read a chain from plain text.

    Parameters
    ----------
    text : str
        In the format described at the head of this module.
    source : str, optional
        Name of the text in messages, such as a file's name.

    Raises
    ------
    InputError
        With a sentence for each line that cannot be used.
    """
    try:
        return _read(text)
    except InputError as error:
        raise InputError(
            joined("\n", (f"{source}: {kept(sentence)}" for sentence in error.sentences))
        ) from None


def _read(text: str) -> ChainText:
    kind: Motion | None = None
    title = ""
    nodes: dict[str, dict[str, float]] = {}
    links: list[_Link] = []
    errors = InputErrors()
    for number, raw in enumerate(text.splitlines(), start=1):
        line = raw.split("#", 1)[0].rstrip()
        if not line.strip():
            continue
        where = f"line {number}"
        if kind is None:
            heading = HEADING.fullmatch(line.strip())
            if heading is None:
                raise InputError(
                    f"{where}: given {line.strip()!r}; allowed is torsional or axial, with a colon and a "
                    "name if wanted, because units follow from it."
                )
            kind = "torsional" if heading[1] == "torsional" else "axial"
            title = (heading[2] or "").strip()
            continue
        with errors.noted():
            if line[0].isspace():
                above = next(reversed(nodes), None)
                links.append(_link(where, COLUMNS.split(line.strip()), UNITS[kind], above))
                continue
            name, values = _node(where, COLUMNS.split(line), UNITS[kind])
            if name in nodes:
                raise InputError(
                    f"{where}: given node {name!r} a second time; allowed is a different name for each, "
                    "because results are named by them."
                )
            for link in links:
                if link.right is None:
                    link.right = name
            nodes[name] = values
    if kind is None:
        raise InputError("given no line; allowed is a heading, torsional or axial, and nodes.")
    errors.tell()
    return ChainText(kind, title, _chain(nodes, links))


def _node(where: str, columns: list[str], units: dict[str, str]) -> tuple[str, dict[str, float]]:
    if len(columns) < 2:
        raise InputError(
            f"{where}: given {columns[0]!r} alone; allowed is a name, two spaces, and an inertia such as "
            f"1.5 {units['inertia']}, because a node has one (lines of elements are indented)."
        )
    values = {"inertia": parse_quantity(columns[1], units["inertia"], f"{where}: inertia")}
    for column in columns[2:]:
        match = NODE_COLUMN.fullmatch(column)
        if match is None:
            raise InputError(
                f"{where}: given {column!r}; allowed are {', '.join(NODE_WORDS)}, each with a quantity."
            )
        word, text = match.groups()
        unit = units["damping" if word == "ground damping" else "stiffness"]
        values[word.removesuffix(" stiffness")] = parse_quantity(text, unit, f"{where}: {word}")
    return columns[0], values


def _link(where: str, columns: list[str], units: dict[str, str], above: str | None) -> _Link:
    link = _Link(where, above)
    for place, column in enumerate(columns):
        word = next((word for word in LINK_WORDS if column.startswith(f"{word} ")), None)
        rest = column[len(word) :].strip() if word else column
        if word == "from":
            link.left = rest
        elif word == "to":
            link.right = rest
        elif word in ("loss", "gear"):
            try:
                ratio = float(rest)
            except ValueError:
                raise InputError(
                    f"{where}: {word}: given {rest!r}; allowed is a number without a unit, because it is a "
                    "ratio."
                ) from None
            link.values[word] = parse_quantity(ratio, "", f"{where}: {word}")
        elif word is not None:
            unit = units["inertia" if word == "inertia" else "damping"]
            link.values[word] = parse_quantity(rest, unit, f"{where}: {word}")
        elif place == 0:
            link.values["stiffness"] = parse_quantity(
                rest, units["stiffness"], f"{where}: stiffness"
            )
        else:
            raise InputError(
                f"{where}: given {column!r}; allowed are {', '.join(LINK_WORDS)} after the stiffness."
            )
    joins = [word for word in ("stiffness", "dashpot", "gear") if word in link.values]
    if len(joins) != 1 or (joins != ["stiffness"] and len(link.values) > 1):
        raise InputError(
            f"{where}: given {', '.join(link.values) or 'nothing'}; allowed is a stiffness (with inertia, "
            "damping or loss), a dashpot or a gear alone, because each is a link of its own."
        )
    return link


def _chain(nodes: dict[str, dict[str, float]], links: list[_Link]) -> Chain:
    numbers = {name: number for number, name in enumerate(nodes)}
    springs, dashpots, gears = [], [], []
    errors = InputErrors()
    for link in links:
        with errors.noted():
            left, right = (_place(link, name, numbers) for name in (link.left, link.right))
            try:
                if "gear" in link.values:
                    gears.append(Gear(left, right, link.values["gear"]))
                elif "dashpot" in link.values:
                    dashpots.append(Dashpot(left, right, link.values["dashpot"]))
                else:
                    springs.append(((left, right), link.values))
            except InputError as error:
                raise InputError(f"{link.line}: {kept(str(error))}") from None
    errors.tell()
    return Chain(
        [values["inertia"] for values in nodes.values()],
        [values["stiffness"] for _, values in springs],
        [values.get("ground", 0.0) for values in nodes.values()],
        connections=[pair for pair, _ in springs],
        damping=[values.get("damping", 0.0) for _, values in springs],
        loss_factor=[values.get("loss", 0.0) for _, values in springs],
        ground_damping=[values.get("ground damping", 0.0) for values in nodes.values()],
        distributed_inertia=[values.get("inertia", 0.0) for _, values in springs],
        dashpots=dashpots,
        gears=gears,
        names=list(nodes),
    )


def _place(link: _Link, name: str | None, numbers: dict[str, int]) -> int:
    if name is None:
        raise InputError(
            f"{link.line}: given a link without a node {'above' if link.left is None else 'below'} it; "
            "allowed is one between two nodes, or with their names after from and to, because it joins two."
        )
    check_choice(link.line, name, numbers, "these are the nodes")
    return numbers[name]


def write_chain_text(chain: Chain, kind: Motion, name: str = "") -> str:
    """Write a chain as plain text, which reads back as the same chain to the last digit.

    Parameters
    ----------
    chain : Chain
    kind : {"torsional", "axial"}
    name : str, optional

    Raises
    ------
    InputError
        If the kind is unknown, springs vary, or a name cannot be written in the text.
    """
    if chain.varying:
        raise InputError(
            "chain: given springs that vary; allowed are constant ones, because plain text has no words for "
            "the others (a TOML file has)."
        )
    if kind not in UNITS:
        raise InputError(
            f"kind: given {kind!r}; allowed are torsional and axial, because units follow from it."
        )
    for key, text in (("name", name), *(("names", text) for text in chain.names)):
        if (key == "names" or text) and not (
            text == text.strip()
            and text.splitlines() == [text]
            and "#" not in text
            and COLUMNS.search(text) is None
        ):
            raise InputError(
                f"{key}: given {text!r}; allowed are names on one line, with single spaces and without "
                "#, because two spaces separate columns and # begins a comment."
            )
    units = UNITS[kind]
    lines = [f"{kind}: {name}" if name else kind]
    of_elements = (
        ("inertia", chain.distributed_inertia, f" {units['inertia']}"),
        ("damping", chain.damping, f" {units['damping']}"),
        ("loss", chain.loss_factor, ""),
    )
    of_nodes = (
        ("ground", chain.ground, f" {units['stiffness']}"),
        ("ground damping", chain.ground_damping, f" {units['damping']}"),
    )
    springs = [
        _columns([f"{float(stiffness)!r} {units['stiffness']}"], number, of_elements)
        for number, stiffness in enumerate(chain.stiffness)
    ]
    links = list(zip(chain.connections, springs, strict=True))
    waiting = 0
    for node, node_name in enumerate(chain.names):
        while waiting < len(links) and max(links[waiting][0]) <= node:
            pair, text = links[waiting]
            if pair != (node - 1, node):
                break
            lines.append(f"  {text}")
            waiting += 1
        inertia = f"{float(chain.inertia[node])!r} {units['inertia']}"
        lines.append(_columns([node_name, inertia], node, of_nodes))
    rest = links[waiting:]
    rest += [
        ((d.left, d.right), f"dashpot {d.damping!r} {units['damping']}") for d in chain.dashpots
    ]
    rest += [((g.driver, g.driven), f"gear {g.ratio!r}") for g in chain.gears]
    for (left, right), text in rest:
        lines.append(f"  {text}  from {chain.names[left]}  to {chain.names[right]}")
    return "\n".join(lines) + "\n"


def _columns(first: list[str], place: int, others: Iterable[tuple[str, Array, str]]) -> str:
    """Write the first columns of a line, and those of the others that are above zero there."""
    above_zero = (
        f"{word} {float(values[place])!r}{unit}"
        for word, values, unit in others
        if values[place] > 0.0
    )
    return "  ".join([*first, *above_zero])


# Sizes within which all calculations keep their digits.
SMALLEST, LARGEST = 1e-20, 1e20
SIZES = ("inertia", "stiffness", "ground", "damping", "ground_damping", "distributed_inertia")


@frozen("name", "kind", "path", "chain.inertia", "chain.stiffness")
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
    printed : tuple of str
        The values as a maker prints them, where they are given so, and in SI.
    joints : tuple of str
        Nodes that pieces of shaft join in a row from the first one, and that one.
    shafts : tuple of ShaftCone
        These pieces.
    """

    path: Path
    name: str
    kind: Motion
    chain: Chain
    records: tuple[InputRecord, ...]
    sources: dict[str, str]
    printed: tuple[str, ...] = ()
    joints: tuple[str, ...] = ()
    shafts: tuple[ShaftCone, ...] = ()


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
    place = file.path
    if place.suffix.lower() != ".toml":
        allowed = "an input file (TOML) or the text of a chain"
        read = read_chain_text(
            file.text(LARGEST_TEXT_FILE, "the text of a chain", allowed), place.name
        )
        _check_sizes(place.name, read.chain)
        return ChainFile(place, read.name or place.stem, read.kind, read.chain, (), {})
    sent = None if file.sent is None else {str(place): file.sent}
    return _read_chain(read_toml(InputFiles(place, sent)))


def _read_chain(content: TomlFile) -> ChainFile:
    path = content.path
    kind = content.sections.get("chain", {}).get("kind")
    known = isinstance(kind, str) and kind in KINDS
    with content.all_errors(
        {"material": Material} | ({"chain": KINDS[str(kind)].section} if known else {})
    ):
        content.check_sections({"chain": True, "material": False})
        if not known:
            raise InputError(
                f"{path.name}: chain.kind: given {kind!r}; allowed are torsional and axial, because units "
                "follow from it."
            )
        section = content.required("chain", KINDS[str(kind)].section)
        material = content.model("material", Material) or STEEL
    try:
        chain = chain_of(section, material)
    except InputError as error:
        raise InputError(
            joined("\n", (f"{path.name}: {kept(sentence)}" for sentence in error.sentences))
        ) from None
    _check_sizes(path.name, chain)
    return ChainFile(
        path,
        section.name,
        section.kind,
        chain,
        tuple(content.records),
        content.sources,
        as_printed(chain, content.sections["chain"], UNITS[section.kind]),
        *shaft_row(section, material),
    )


def _check_sizes(file: str, chain: Chain) -> None:
    """Refuse numbers so small or large that their squares underflow or overflow."""
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


# Longest span between bearings of a shaft line per root of its diameter [m^0.5]: 450 times the root of the
# diameter in mm, as classification societies allow with white metal and oil.
LONGEST_SPAN = 0.45 * math.sqrt(1000.0)
# The key of a whole plant's chain, as its maker gives it.
PLANT = "plant"


def read_shaft_lines(content: TomlFile) -> tuple[dict[str, Chain], LineBeam | None]:
    """Read the chains that the section [shaft_line] of an engine file names, by their kind, and how it bends.

    Their values are listed with those of the engine file.
    """
    lines = content.model("shaft_line", ShaftLineFiles)
    chains: dict[str, Chain] = {}
    rows: list[ChainFile] = []
    for key, kind in (("torsional", "torsional"), ("axial", "axial"), (PLANT, "torsional")):
        name = None if lines is None else getattr(lines, key)
        if name is None:
            continue
        read = load_chain(content.files.named(f"shaft_line.{key}", name, "chains"))
        if read.kind != kind:
            why = "replaces" if key == PLANT else "continues"
            raise InputError(
                f"shaft_line.{key}: given {name!r}, a chain of kind {read.kind}; allowed is one of kind "
                f"{kind}, because it {why} that chain of the engine."
            )
        chains[key] = read.chain
        rows += [read] if read.shafts and key != PLANT else []
        content.records.extend(
            replace(record, field=f"shaft_line.{key}: {record.field}") for record in read.records
        )
    if lines is None or not (rows or lines.bearings):
        return chains, None
    if not rows:
        raise InputError(
            "shaft_line.bearings: given for a line without a piece of shaft behind its first node; allowed "
            "is one in which the one element behind it has a shape, because only pieces of shaft bend."
        )
    return chains, _line_beam(rows[0], chains, lines)


def _line_beam(row: ChainFile, chains: dict[str, Chain], lines: ShaftLineFiles) -> LineBeam:
    """Return the pieces of a line with the bodies that either chain has at their ends, on its bearings."""

    def bodies(kind: str) -> tuple[float, ...]:
        chain = chains.get(kind)
        known = {} if chain is None else dict(zip(chain.names, chain.inertia.tolist(), strict=True))
        return tuple(known.get(joint, 0.0) for joint in row.joints)

    thinnest = min(min(each.left_diameter, each.right_diameter) for each in row.shafts)
    length = math.fsum(each.length for each in row.shafts)
    places = lines.bearings
    if places is None:
        spans = math.ceil(length / (LONGEST_SPAN * math.sqrt(thinnest)))
        places = tuple(length * number / spans for number in range(1, spans + 1))
    for place in places:
        if not 0.0 <= place <= length:
            raise InputError(
                f"shaft_line.bearings: given one at {amount(place, 'm')}; allowed is 0 to "
                f"{amount(length, 'm')}, because the pieces of shaft in a row behind the first node are so "
                "long."
            )
    stiffness = lines.bearing_stiffness or ASSUMED_PER_DIAMETER * thinnest
    bearings = tuple((place, stiffness) for place in places)
    return LineBeam(row.shafts, bodies("axial"), bodies("torsional"), bearings)


def plant_chain(plant: Chain, cylinders: Sequence[int]) -> EngineChain:
    """Return the chain of a plant that its maker gives, with the nodes of its cranks.

    Parameters
    ----------
    cylinders : sequence of int
        Number of cylinders on each throw, from the free end.
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
