"""Files with a text in any one field that the models of files have, and what may not come back."""

import json
import tomllib
import typing
from copy import deepcopy
from pathlib import Path

from crankbase.model import field_extra, part_kind
from crankfem.files.chain.chain_build import KINDS as CHAIN
from crankfem.files.engine.file_kinds import SECTIONS
from crankfem.files.reading.data_files import input_path, shipped_names
from crankfem.files.satellites import at_place, satellite_files

# Of each kind of file one that is shipped, and its sections.
FILES = {
    "engine": ("6chn25-34", {name: one.model for name, one in SECTIONS.items()}),
    **{
        kind: (shipped_names(kind)[0], at_place(own.sections))
        for kind, own in satellite_files().items()
    },
    "chain": ("geared-example", {"chain": CHAIN["torsional"].section}),
}
SECRET = "secret-7f3a91"
# Sections, other than those of the shipped files, in which a field can name a file.
FITTING = {
    ("gas", "pressure_table"): {},
    ("gas_map", "points", "pressure_table"): {
        "points": [
            {"speed": "9 1/min", "load": 1.0},
            {"speed": "900 1/min", "load": 1.0, "pressure_table": "none.csv"},
        ]
    },
    ("study", "file"): {"design": "file"},
    ("operation", "points", "gas_force_table"): {"points": [{"speed": "89 1/min"}]},
}


def fields():
    """Every field of every section: kind of file, path in it, whether it takes any text, and names a file."""
    for kind, (_, sections) in FILES.items():
        for section, model in sections.items():
            for path, info in _leaves(model):
                takes = any(word in str(info.annotation) for word in ("str", "Path", "Any"))
                says = (info.description or "").lower()
                file = any(word in says for word in ("csv file", "chain file", "saved compliance"))
                yield kind, (section, *path), takes, takes and file


def text_with(kind, path, value):
    """A shipped file with a value in one field, and what else its section needs."""
    name, sections = FILES[kind]
    content = tomllib.loads(input_path(name, kind).read_text(encoding="utf-8"))
    section, *inner = path
    if section == "throws":
        content["throws"] = {"a": content.pop("throw")}
        place, model = content["throws"]["a"], sections["throws"]
    else:
        model = sections[section]
        if path in FITTING:
            content[section] = deepcopy(FITTING[path])
        place = content.setdefault(section, _needed(model))
    for name in inner[:-1]:
        model = part_kind(model.model_fields[name])
        if name not in place:
            place[name] = [_needed(model)]
        place = place[name][0] if isinstance(place[name], list) else place[name]
    place[inner[-1]] = value
    return toml_text(content)


def toml_text(content):
    """Content as a file, each section in one line."""
    return "\n".join(f"{key} = {_value(one)}" for key, one in content.items())


def tells(answer, *places):
    """What of the secret, or of the server's places, an answer has."""
    return [word for word in (SECRET, *map(str, places)) if word in answer]


def plant(folder):
    """Files that nobody may read, one for each kind of content: each says the secret where it is wrong."""
    folder.mkdir(exist_ok=True)
    for ending, text in {
        "csv": f"{SECRET},{SECRET}\n1,{SECRET}\n",
        "toml": f"[{SECRET}]\n{SECRET} = 1\n",
        "json": f'{{"{SECRET}": "{SECRET}"}}',
        "txt": f"{SECRET}:x:0:0\n",
    }.items():
        (folder / f"planted.{ending}").write_text(text, encoding="utf-8")
    return sorted(folder.glob("planted.*"))


def _leaves(model):
    for name, info in model.model_fields.items():
        part = part_kind(info)
        if part is None:
            yield (name,), info
        else:
            yield from (((name, *path), leaf) for path, leaf in _leaves(part))


def _needed(model):
    """Values for the fields that a record cannot be without."""
    found = {}
    for name, info in model.model_fields.items():
        if not info.is_required():
            continue
        unit, kind = field_extra(info, "unit"), info.annotation
        if unit is not None:
            low, high = (field_extra(info, f"{end}imum_si") for end in ("min", "max"))
            middle = 1.0 if None in (low, high) else 0.5 * (low + high)
            found[name] = f"{middle} {unit}" if unit else middle
        elif typing.get_origin(kind) is typing.Literal:
            found[name] = typing.get_args(kind)[0]
        else:
            found[name] = "x" if kind is str else 1
    return found


def _value(value):
    if isinstance(value, dict):
        return "{" + ", ".join(f"{json.dumps(k)} = {_value(v)}" for k, v in value.items()) + "}"
    if isinstance(value, list):
        return "[" + ", ".join(map(_value, value)) + "]"
    return json.dumps(value)


def upwards(file):
    """The path of a file from the deepest folder that a service may work in."""
    return str(Path("../" * 30) / file.relative_to("/"))
