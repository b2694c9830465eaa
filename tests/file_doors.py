"""Every value of a file changed, and what a door makes of it: a command or call that reads the file.

A number is changed by 3 %, a count by one, a choice to each other one, true to false, another word or the
name of a file to one that is not there. What the door prints as JSON, without what only repeats the file,
must change; or the door refuses the file; or it lists the field among those that it does not use. Anything
else is left over.
"""

import json
import math
import re
import shutil
import tempfile
import tomllib
import typing
from collections.abc import Callable, Collection, Iterator, Sequence
from copy import deepcopy
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from typer.testing import CliRunner

from crankbase.errors import InputError, MeshError, SolveError
from crankbase.model import part_kind
from crankfem.files.reading.data_files import input_path, shipped_names
from crankfem.files.satellites import satellite_files
from dynamics.assessment.limit_rules import RULE_OF_DRIVEN
from file_fields import FILES, toml_text
from satellite_cases import of_satellites

SHARE = 0.03
# What is held against something, as a limit for passing, must be crossed to change the answer: it is doubled
# and halved where 3 % change nothing, and then only a changed answer counts.
WIDER = (1.0, -0.5)
ROUND_OFF = 1e-7
CHANGED, REFUSED, NAMED, LEFT, WRONG = WORDS = (
    *("changed", "refused", "named", "left over"),
    "named, but changed",
)
# Of fields that take any text, the words that they may be.
WORDS_OF = {
    **dict.fromkeys(("axial_source", "torsional_source"), ("fe", "law")),
    "drives": tuple(RULE_OF_DRIVEN),
}
# When a file was written, and the how many-th solid of the process it is.
DATE = re.compile(r"\d{4}-\d\d-\d\d[T ][\d:.]+|STEP translator [\d. ]+")
COARSE = 0.1
NUMBER = re.compile(r"\s*([+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?)(.*)", re.DOTALL)
# What repeats the file, and what differs from run to run.
ECHO = {
    *("inputs", "dimensions", "material", "assumed", "arrangement", "seconds", "about", "file"),
    *("files", "units", "sources", "not_used", "pictures"),
}
Content = dict[str, Any]


@dataclass(frozen=True)
class Change:
    """A value of a file to be changed: its path without places in lists, and with them; the other value."""

    path: tuple[str, ...]
    keys: tuple[Any, ...]
    value: Any

    @property
    def field(self) -> str:
        """The path as a file's messages have it."""
        return ".".join(self.path)

    def is_named(self, names: Collection[str]) -> bool:
        """Whether a list of fields and sections has it."""
        return any(self.field == name or self.field.startswith(f"{name}.") for name in names)


def changed(content: Content, *changes: Change) -> Content:
    """Content with some values changed."""
    content = deepcopy(content)
    for change in changes:
        place: Any = content
        for key in change.keys[:-1]:
            place = place[key]
        place[change.keys[-1]] = change.value
    return content


def changes(kind: str, content: Content, share: float = SHARE) -> Iterator[Change]:
    """Each value of a file that is no name and no words about another, changed; a number by a share of it."""
    for path, keys, value in leaves(content):
        for other in _others(kind, path, value, share):
            yield Change(path, keys, other)


def leaves(
    value: Any, path: tuple[str, ...] = (), keys: tuple[Any, ...] = ()
) -> Iterator[tuple[tuple[str, ...], tuple[Any, ...], Any]]:
    """Values with their paths, of lists of tables the first and the last one."""
    if isinstance(value, dict) and "value" in value:
        yield path, (*keys, "value"), value["value"]
    elif isinstance(value, dict):
        for name, part in value.items():
            yield from leaves(part, (*path, name), (*keys, name))
    elif isinstance(value, list) and value and isinstance(value[0], dict):
        for place in sorted({0, len(value) - 1}):
            yield from leaves(value[place], path, (*keys, place))
    else:
        yield path, keys, value


def _others(kind: str, path: tuple[str, ...], value: Any, share: float) -> Iterator[Any]:
    """Other values that a field may have."""
    if isinstance(value, bool):
        yield not value
    elif isinstance(value, int):
        yield value + 1
    elif isinstance(value, float):
        yield value * (1.0 + share) if value else share
    elif isinstance(value, list):
        places = [place for place, one in enumerate(value) if not _is_zero(one)]
        for place in places[-1:]:
            for other in _others(kind, path, value[place], share):
                yield [*value[:place], other, *value[place + 1 :]]
    elif isinstance(value, str):
        choices = _choices(kind, path) or WORDS_OF.get(path[-1], ())
        number = NUMBER.fullmatch(value)
        if choices:
            yield from (choice for choice in choices if choice != value)
        elif path[-1] in ("name", "source"):
            return
        elif path[-1] == "firing_order":
            yield "-".join(reversed(value.split("-")))
        elif number is not None:
            size = float(number[1])
            yield f"{size * (1.0 + share) if size else 1.0!r}{number[2]}"
        else:
            yield f"no {value}"


def _is_zero(value: Any) -> bool:
    if isinstance(value, str):
        number = NUMBER.fullmatch(value)
        return number is not None and float(number[1]) == 0.0
    return value == 0


def _choices(kind: str, path: tuple[str, ...]) -> tuple[str, ...]:
    """Words that a field may be, by its declaration."""
    section, *inner = path
    model = FILES[kind][1].get(section)
    inner = inner[1:] if section == "throws" else inner
    for name in inner:
        if model is None or name not in model.model_fields:
            return ()
        info = model.model_fields[name]
        if name == inner[-1]:
            kinds = (info.annotation, *typing.get_args(info.annotation))
            literals = [one for one in kinds if typing.get_origin(one) is typing.Literal]
            return tuple(word for one in literals for word in typing.get_args(one))
        model = part_kind(info)
    return ()


@dataclass(frozen=True)
class Answer:
    """What a door says, and the fields that it names as not used."""

    content: Any
    named: tuple[str, ...] = ()

    def same(self, other: "Answer") -> bool:
        """Whether another answer is the same but for round-off."""
        return _same(self.content, other.content)


def _same(first: Any, second: Any, size: float = 0.0) -> bool:
    if isinstance(first, dict) and isinstance(second, dict):
        return first.keys() == second.keys() and all(_same(first[k], second[k]) for k in first)
    if isinstance(first, list) and isinstance(second, list):
        sizes = [abs(one) for one in first if isinstance(one, float)]
        size = max([size, *sizes])
        return len(first) == len(second) and all(
            _same(one, other, size) for one, other in zip(first, second, strict=True)
        )
    if isinstance(first, float) and isinstance(second, float):
        return math.isclose(first, second, rel_tol=ROUND_OFF, abs_tol=ROUND_OFF * size)
    return bool(first == second)


Door = Callable[[Path], Answer]


def command(*words: str) -> Door:
    """A command of the command line; FILE in its words is the file, OUT a file that it writes."""

    def asked(file: Path) -> Answer:
        from crankfem.cli.app import app

        with tempfile.TemporaryDirectory() as folder:
            made = Path(folder, "made")
            line = [word.replace("FILE", str(file)).replace("OUT", str(made)) for word in words]
            found = CliRunner().invoke(app, [*line, "--json"], standalone_mode=False)
            if found.exception is not None:
                raise found.exception
            text = found.stdout.replace(folder, "").replace(str(file.parent), "")
            record = json.loads(text, parse_int=float)
            written = sorted(path for path in Path(folder).rglob("made*") if path.is_file())
            files = [DATE.sub("", path.read_text(encoding="latin-1")) for path in written]
        return Answer([_plain(record), files], tuple(record.get("not_used", ())))

    return asked


def _plain(record: Any) -> Any:
    if isinstance(record, dict):
        return {name: _plain(part) for name, part in record.items() if name not in ECHO}
    if isinstance(record, list):
        return list(map(_plain, record))
    return record


def without(*sections: str, door: Door) -> Door:
    """A door for the file without some sections: cheaper, and a part of the answer with them."""

    def asked(file: Path) -> Answer:
        content = {
            k: v for k, v in tomllib.loads(file.read_text("utf-8")).items() if k not in sections
        }
        fewer = file.with_name(f"fewer-{file.name}")
        fewer.write_text(toml_text(content), encoding="utf-8")
        return door(fewer)

    return asked


def once(door: Door) -> Door:
    """A door that several others have as a part: each file is given to it once."""
    answers: dict[str, Answer | Exception] = {}

    def asked(file: Path) -> Answer:
        text = file.read_text(encoding="utf-8")
        if text not in answers:
            try:
                answers[text] = door(file)
            except REFUSALS as error:
                answers[text] = error
        answer = answers[text]
        if isinstance(answer, Answer):
            return answer
        raise answer

    return asked


REFUSALS = (InputError, MeshError, SolveError, SystemExit)
vibrations: dict[str, Any] = {}


def vibration_of(file: Path) -> Any:
    """Vibration of an engine: the same one for files that differ in what it does not use."""
    from crankfem.analyses.vibration.run import engine_vibration
    from crankfem.files.engine.engine_file import load_engine
    from crankfem.files.engine.used_values import RUN_ALONE

    content = tomllib.loads(file.read_text(encoding="utf-8"))
    text = toml_text({name: part for name, part in content.items() if name not in RUN_ALONE})
    engine = load_engine(file)
    if text not in vibrations:
        vibrations[text] = engine_vibration(engine)
    return replace(vibrations[text], engine_file=engine)


def named_by(file: Path, name: str) -> tuple[str, ...]:
    """What a command does not use of a file."""
    from crankfem.files.engine.used_values import not_used
    from crankfem.files.reading.toml_file import read_toml

    return not_used(read_toml(file), name)


def vibration(file: Path) -> Answer:
    """The results of `vibration`."""
    return Answer(
        _plain(json.loads(json.dumps(vibration_of(file).to_record()))), named_by(file, "vibration")
    )


def rest_of_run(file: Path) -> Answer:
    """What a run has beside vibration and mechanism; its study is planned, not run."""
    from crankfem.analyses.mechanism.two_masses import checked
    from crankfem.analyses.strength.engine_strength import engine_strength
    from crankfem.jobs.run_computation import read_inputs

    inputs = read_inputs(file)
    answer: list[Any] = [inputs.study and inputs.study.key]
    if inputs.torque is not None:
        harmonics = inputs.torque.harmonics()
        answer += [harmonics.mean, harmonics.amplitude.tolist(), harmonics.phase.tolist()]
        if inputs.engine_file.two_mass is not None:
            answer.append(
                json.loads(json.dumps(checked(inputs.engine_file.two_mass, harmonics).to_record()))
            )
    if inputs.engine_file.strength is not None:
        strength = engine_strength(vibration_of(file))
        answer.append(_plain(json.loads(json.dumps(strength.to_record()))))
    return Answer(answer, named_by(file, "run"))


PRESSURE = ("gas", "gas_map", "load", "misfire", "ranges", "limits", "strength", "propeller_forces")


def torsional(door: Door) -> Door:
    """The torsional part of an answer alone."""

    def asked(file: Path) -> Answer:
        whole = door(file)
        return Answer(whole.content[0]["torsional"], whole.named)

    return asked


modes = once(without(*PRESSURE, door=command("vibration", "FILE")))
forced = once(vibration)
coupled = once(command("vibration", "FILE", "--coupled"))
# Of each door the kind of its files, and what has parts of its answer, then all of it: what is cheap first.
DOORS: dict[str, tuple[str | Door, ...]] = {
    "throw": ("engine", command("throw", "FILE")),
    "formulas": ("engine", command("formulas", "FILE")),
    "lookup law": ("engine", command("lookup", "law", "--throw", "FILE")),
    "draw": ("engine", command("draw", "FILE", "--output", "OUT.svg")),
    "export": ("engine", command("export", "FILE", "OUT.msh")),
    "export --calculix": ("engine", command("export", "FILE", "OUT.inp", "--calculix")),
    "export --shaft": ("engine", command("export", "FILE", "OUT.step", "--shaft")),
    "mechanism": ("engine", command("mechanism", "FILE")),
    "harmonics": ("engine", command("harmonics", "FILE")),
    "plan": ("engine", command("plan", "FILE")),
    "two-mass": ("engine", command("two-mass", "FILE")),
    "vibration": ("engine", modes, forced),
    "vibration --coupled": ("engine", modes, forced, coupled),
    **{name: ("engine", *doors) for name, doors in of_satellites("DOORS").items()},
    "run": ("engine", modes, command("mechanism", "FILE"), forced, coupled, rest_of_run),
    "stress": ("engine", command("stress", "FILE", "--accuracy", "0.2")),
    **{kind: (kind, command(own.command, "FILE")) for kind, own in satellite_files().items()},
    "chain": ("chain", command("vibration", "FILE")),
}


def shipped_content(kind: str, name: str) -> Content:
    """Content of a shipped file."""
    content = tomllib.loads(input_path(name, kind).read_text(encoding="utf-8"))
    content.pop("sources", None)
    return content


def beside(name: str, kind: str, folder: Path) -> None:
    """Put the files beside a file that is not shipped, which it may name, into a folder."""
    if name not in shipped_names(kind):
        for path in Path(name).parent.glob("*.*"):
            shutil.copy(path, folder)


def coarsely() -> None:
    """Analyze each throw once, with a coarse mesh; condense each mesh once."""
    import crankfem.analyses.shaft.throw_analyses as shaft
    import fem.analysis
    from stand_ins import condensed_once

    real, known = fem.analysis.analyze_throw, {}

    def analyzed(throw: Any, material: Any, accuracy: float = COARSE, **options: Any) -> Any:
        key = throw, material, tuple(sorted((name, repr(one)) for name, one in options.items()))
        if key not in known:
            known[key] = real(throw, material, COARSE, **options)
        return known[key]

    fem.analysis.analyze_throw = shaft.analyze_throw = analyzed  # type: ignore[assignment]
    fem.analysis.dynamic_superelement = condensed_once  # type: ignore[assignment]


def look(
    doors: Sequence[Door], kind: str, content: Content, folder: Path
) -> Iterator[tuple[Change, str]]:
    """Return of each change what a door makes of it, which is the last of these; the others are parts of it.

    What it names is changed all at once, and one by one only if that changes the answer.
    """
    file = folder / "file.toml"

    def asked(door: Door, *some: Change) -> Answer | None:
        file.write_text(toml_text(changed(content, *some)), encoding="utf-8")
        try:
            return door(file)
        except REFUSALS as error:
            if not some:
                raise ValueError(str(error)) from None
            return None

    before = [asked(door) for door in doors]
    names = getattr(before[-1], "named", ())

    def outcome(*some: Change) -> str:
        for door, answer in zip(doors, before, strict=True):
            after = asked(door, *some)
            if after is None:
                return REFUSED
            if not after.same(answer):
                return CHANGED
        return LEFT

    def single(change: Change) -> str:
        told = outcome(change)
        wider = [
            other
            for share in WIDER
            for other in changes(kind, content, share)
            if told == LEFT and other.keys == change.keys and other != change
        ]
        return CHANGED if any(outcome(other) == CHANGED for other in wider) else told

    every = list(changes(kind, content))
    named = [change for change in every if change.is_named(names)]
    alike = outcome(*named) == LEFT
    for change in every:
        if change not in named:
            yield change, single(change)
        elif alike:
            yield change, NAMED
        else:
            told = outcome(change)
            yield change, {LEFT: NAMED, CHANGED: WRONG}.get(told, told)
