"""What the pages of the API reference are made of: every public name, sorted by topic.

Needs nothing but the standard library. Public names are those of crankfem/__init__.pyi; a topic is a
list of the modules that they come from.
"""

import ast
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]


@dataclass(frozen=True)
class Topic:
    """A page of the reference: its file, title, a sentence, and modules or packages by their names."""

    file: str
    title: str
    text: str
    homes: tuple[str, ...]


@dataclass(frozen=True)
class PublicName:
    """A name of crankfem, where it comes from, and what its docstring begins with."""

    name: str
    module: str
    name_there: str
    summary: str


TOPICS = (
    Topic(
        "engines",
        "Engines and whole runs",
        "Engine files, the main job, and the vibration of an engine in one call.",
        (
            "crankfem.files.engine.engine_file",
            "crankfem.jobs.pipeline",
            "crankfem.analyses.vibration.assessment",
            "crankfem.analyses.vibration.forced",
            "crankfem.analyses.vibration.modes",
            "crankfem.analyses.vibration.run",
        ),
    ),
    Topic(
        "throws",
        "Throws, masses, meshes",
        "Dimensions of throws and crankshafts, what they weigh, their solids and meshes.",
        (
            "crankfem.files.engine.throw_file",
            "geometry.balance",
            "geometry.crankshaft",
            "geometry.imported",
            "geometry.mass",
            "geometry.mesh",
            "geometry.mesh_files",
            "geometry.mesher",
            "geometry.shaft_ends",
            "geometry.solid_files",
            "geometry.throw",
            "geometry.throw_sections",
        ),
    ),
    Topic(
        "compliance",
        "Compliance and stress by finite elements",
        "Analyses of throws, their supports, superelements, assembled shafts, fillet stresses.",
        (
            "fem.analysis",
            "fem.angle_law",
            "fem.axial_analysis",
            "fem.calculix",
            "fem.craig_bampton",
            "fem.dynamic_shaft",
            "fem.fillet_peaks",
            "fem.fillet_stress",
            "fem.material",
            "fem.modes",
            "fem.pin_response",
            "fem.shaft",
            "fem.supports",
            "fem.throw_analysis",
        ),
    ),
    Topic(
        "equations",
        "Studies, equations, formulas",
        "Designs of experiments, regression models that answer lookups, and the published formulas.",
        (
            "crankfem.analyses.study.fitting",
            "crankfem.analyses.throw.formula_diagrams",
            "crankfem.analyses.study.studies",
            "regression",
        ),
    ),
    Topic(
        "mechanism",
        "Crank mechanism and gas",
        "Motion, forces and bearing loads of rods and pistons; the pressure that drives them.",
        (
            "crankfem.files.engine.mechanism_file",
            "crankfem.analyses.mechanism.mechanism_run",
            "dynamics.engine",
            "dynamics.gas",
            "dynamics.mechanism",
        ),
    ),
    Topic(
        "torque",
        "Torque, harmonics, free turning",
        "Torque over the cycle, its harmonics and stars, and a crank that is left to turn.",
        (
            "crankfem.files.reading.torque_file",
            "dynamics.harmonics",
            "dynamics.torque",
            "dynamics.torque_table",
            "dynamics.turning",
        ),
    ),
    Topic(
        "balance",
        "Balance",
        "Inertia forces and moments by order, counterweights, hodographs, hinged rods.",
        ("dynamics.balance",),
    ),
    Topic(
        "chains",
        "Chains",
        "Chains of lumped masses: torsional and axial, with gears, dampers, shaft lines and absorbers.",
        (
            "crankfem.files.chain.chain_file",
            "crankfem.files.chain.chain_text",
            "dynamics.chains",
            "dynamics.critical",
        ),
    ),
    Topic(
        "excitation",
        "Excitation",
        "What makes a crankshaft vibrate: forces of cylinders and propellers by order and speed.",
        ("dynamics.excitation",),
    ),
    Topic(
        "response",
        "Forced vibration",
        "Amplitudes, loads, stresses and heat by order over the speeds, and resonances.",
        ("dynamics.response",),
    ),
    Topic(
        "crankshaft",
        "The whole crankshaft",
        "Superelements joined to a crankshaft: coupled modes and vibration.",
        ("crankfem.analyses.shaft.whole_shaft", "dynamics.crankshaft"),
    ),
    Topic(
        "transient",
        "Vibration over time",
        "Run-ups, load steps, failing cylinders, inertia that changes with the crank angle.",
        ("crankfem.analyses.vibration.run_up", "dynamics.transient"),
    ),
    Topic(
        "limits",
        "Limits, verdict, uncertainty",
        "Limits with their sources, barred ranges, dampers of the right size, what uncertain values do.",
        ("dynamics.assessment",),
    ),
    Topic(
        "hinge",
        "Elastic hinge",
        "The pneumatic hinge that evens a crank's speed.",
        ("crankfem.files.hinge.hinge_file", "crankfem.analyses.hinge.hinge_run", "dynamics.hinge"),
    ),
    Topic(
        "pictures",
        "Pictures and tables",
        "Drawings and diagrams written to files, and tables of results.",
        (
            "crankfem.analyses.hinge.plots",
            "crankfem.analyses.mechanism.plots",
            "crankfem.analyses.shaft.plots",
            "crankfem.analyses.throw.pictures",
            "crankfem.analyses.vibration.plots",
            "crankfem.analyses.vibration.vibration_pictures",
            "crankbase.outputs",
            "crankbase.tables.frames",
        ),
    ),
    Topic(
        "errors",
        "Errors",
        "What is raised, always with one sentence.",
        ("fem.solver", "crankbase.errors"),
    ),
)


def public_names(root: Path = ROOT) -> list[PublicName]:
    """Return every public name, as crankfem/__init__.pyi declares them."""
    stub = ast.parse((root / "crankfem" / "__init__.pyi").read_text(encoding="utf-8"))
    summaries: dict[str, dict[str, str]] = {}
    found = []
    for statement in stub.body:
        if not isinstance(statement, ast.ImportFrom):
            continue
        module = str(statement.module)
        if module not in summaries:
            summaries[module] = _summaries(root, module)
        for alias in statement.names:
            summary = summaries[module].get(alias.name) or _further_home(root, module, alias.name)
            found.append(PublicName(alias.asname or alias.name, module, alias.name, summary))
    return sorted(found, key=lambda one: one.name.lower())


def topic_of(module: str) -> Topic:
    """Return the topic of a module.

    Raises
    ------
    ValueError
        If no topic has it.
    """
    for topic in TOPICS:
        if any(module == home or module.startswith(f"{home}.") for home in topic.homes):
            return topic
    raise ValueError(
        f"{module}: has public names but no topic; give it one in docs/hooks/api_topics.py."
    )


def pages(names: list[PublicName]) -> dict[str, str]:
    """Return the pages of the reference: path in the documentation -> Markdown."""
    by_topic: dict[str, list[PublicName]] = {topic.file: [] for topic in TOPICS}
    for name in names:
        by_topic[topic_of(name.module).file].append(name)
    found = {"api/index.md": _index(names)}
    for topic in TOPICS:
        found[f"api/{topic.file}.md"] = _page(topic, by_topic[topic.file])
    return found


def _index(names: list[PublicName]) -> str:
    lines = [
        "# API reference",
        "",
        "Everything a user needs is a name of `crankfem`, imported as `cf`. SI units throughout.",
        "",
        "| topic | what it has |",
        "|---|---|",
        *(f"| [{topic.title}]({topic.file}.md) | {topic.text} |" for topic in TOPICS),
        "",
        f"## All {len(names)} names",
        "",
        "| name | what it is |",
        "|---|---|",
    ]
    for name in names:
        link = f"{topic_of(name.module).file}.md#crankfem.{name.name}"
        lines.append(f"| [`{name.name}`]({link}) | {_cell(name.summary)} |")
    return "\n".join(lines) + "\n"


def _page(topic: Topic, names: list[PublicName]) -> str:
    lines = [f"# {topic.title}", "", topic.text, "", "| name | what it is |", "|---|---|"]
    lines += [f"| [`{one.name}`](#crankfem.{one.name}) | {_cell(one.summary)} |" for one in names]
    for name in names:
        lines += ["", f"::: crankfem.{name.name}"]
    return "\n".join(lines) + "\n"


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
