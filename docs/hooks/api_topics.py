"""What the pages of the API reference are made of: every public name, by topic.

Needs nothing but the standard library. Public names are those that the stubs of crankfem and of its
topics declare; a topic is a folder of crankfem/ with a stub, described by its docstring.
"""

import ast
import re
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
TOP = "crankfem"
TOP_TEXT = "What most work begins with; all else has a name in one of the topics."


@dataclass(frozen=True)
class Topic:
    """A page of the reference: its file, the package, a sentence, and what else its docstring says."""

    file: str
    package: str
    summary: str
    text: str


@dataclass(frozen=True)
class PublicName:
    """A name, the package that hands it out, and what its docstring begins with."""

    name: str
    package: str
    summary: str

    @property
    def path(self) -> str:
        """The whole name."""
        return f"{self.package}.{self.name}"

    @property
    def shown(self) -> str:
        """How it is written in Python."""
        return re.sub(r"^crankfem", "cf", self.path)

    @property
    def file(self) -> str:
        """The page that it stands on."""
        return self.package.removeprefix(f"{TOP}.")


def topics(root: Path = ROOT) -> list[Topic]:
    """Return the topics: crankfem itself first."""
    found = [Topic(TOP, TOP, TOP_TEXT, "")]
    for stub in sorted((root / "crankfem").glob("*/__init__.pyi")):
        package = f"{TOP}.{stub.parent.name}"
        summary, _, text = (ast.get_docstring(_tree(root, package)) or "").partition("\n\n")
        found.append(Topic(stub.parent.name, package, " ".join(summary.split()), text))
    return found


def public_names(root: Path = ROOT) -> list[PublicName]:
    """Return every public name, as the stubs declare them."""
    summaries: dict[str, dict[str, str]] = {}
    found = []
    for topic in topics(root):
        stub = root.joinpath(*topic.package.split("."), "__init__.pyi")
        for statement in ast.parse(stub.read_text(encoding="utf-8")).body:
            if not isinstance(statement, ast.ImportFrom) or statement.module == TOP:
                continue
            module = str(statement.module)
            if module not in summaries:
                summaries[module] = _summaries(root, module)
            for alias in statement.names:
                summary = summaries[module].get(alias.name) or _further_home(
                    root, module, alias.name
                )
                found.append(PublicName(alias.asname or alias.name, topic.package, summary))
    return sorted(found, key=lambda one: one.name.lower())


def pages(names: list[PublicName]) -> dict[str, str]:
    """Return the pages of the reference: path in the documentation -> Markdown."""
    found = {"api/index.md": _index(names)}
    for topic in topics():
        own = [name for name in names if name.package == topic.package]
        found[f"api/{topic.file}.md"] = _page(topic, own)
    return found


def _index(names: list[PublicName]) -> str:
    lines = [
        "# API reference",
        "",
        "What most work begins with is a name of `crankfem`, imported as `cf`; all else has a name in one",
        "topic, as `cf.chains.with_damper`. SI units throughout.",
        "",
        "| topic | what it has |",
        "|---|---|",
        *(
            f"| [`{topic.package}`]({topic.file}.md) | {_cell(topic.summary)} |"
            for topic in topics()
        ),
        "",
        f"## All {len(names)} names",
        "",
        "| name | what it is |",
        "|---|---|",
    ]
    for name in names:
        lines.append(f"| [`{name.shown}`]({name.file}.md#{name.path}) | {_cell(name.summary)} |")
    return "\n".join(lines) + "\n"


def _page(topic: Topic, names: list[PublicName]) -> str:
    lines = [f"# {topic.package}", "", topic.summary]
    if topic.text:
        lines += ["", _fenced(topic.text)]
    lines += ["", "| name | what it is |", "|---|---|"]
    lines += [f"| [`{one.name}`](#{one.path}) | {_cell(one.summary)} |" for one in names]
    for name in names:
        lines += ["", f"::: {name.path}"]
    return "\n".join(lines) + "\n"


def _fenced(text: str) -> str:
    """Return a docstring with its examples as blocks of code."""
    parts = [
        f"```pycon\n{part}\n```" if part.startswith(">>>") else part for part in text.split("\n\n")
    ]
    return "\n\n".join(parts)


def _cell(text: str) -> str:
    return text.replace("|", "\\|")


def _tree(root: Path, module: str) -> ast.Module:
    path = root.joinpath(*module.split("."))
    file = path / "__init__.py" if path.is_dir() else path.with_suffix(".py")
    return ast.parse(file.read_text(encoding="utf-8"))


def _further_home(root: Path, module: str, name: str) -> str:
    """Return the first paragraph of a name that its module has from another one."""
    for node in _tree(root, module).body:
        if isinstance(node, ast.ImportFrom) and name in {alias.name for alias in node.names}:
            return _summaries(root, str(node.module)).get(name, "")
    return ""


def _summaries(root: Path, module: str) -> dict[str, str]:
    """Return the first paragraph of each docstring of a module, by name."""
    tree = _tree(root, module)
    found: dict[str, str] = {}
    for place, node in enumerate(tree.body):
        if isinstance(node, ast.FunctionDef | ast.ClassDef):
            text = ast.get_docstring(node) or ""
            found[node.name] = " ".join(text.split("\n\n")[0].split())
        elif isinstance(node, ast.Assign | ast.AnnAssign) and place + 1 < len(tree.body):
            # A constant may be described by the string below it.
            after = tree.body[place + 1]
            if isinstance(after, ast.Expr) and isinstance(after.value, ast.Constant):
                targets = node.targets if isinstance(node, ast.Assign) else [node.target]
                for target in targets:
                    if isinstance(target, ast.Name):
                        found[target.id] = " ".join(str(after.value.value).split())
    return found
