"""Whether tests notice a wrong formula: 40 changes of one token each, in four packages.

Run by hand: ``python tests/campaigns/mutations.py FOLDER [--count N] [--seed N] [--list] [--again]`` (about
an hour of one core; it continues where it was stopped, ``--again`` tries survivors with the tests of today).

A change is a sign, a sum, a product, a constant, a sine, a comparison, an index or a conjugate in a line
that calculates: no check, text, plot, file or process. The seed chooses: each package has the same number,
the kinds take turns. FOLDER keeps a copy of the checkout, in which the change is made, and results.json.
The affected package's tests run until the first failure: quick ones first, files that import the changed
module before others. A change is caught if a test fails that passes without it.
"""

import argparse
import ast
import hashlib
import json
import os
import re
import shutil
import subprocess
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
PACKAGES = ("geometry", "fem", "regression", "dynamics")
# Modules that draw, check, write, keep or pass on: what they calculate is not of the crank.
OTHER = re.compile(
    r"/(plots|runs)/|_(checks|files?|sentences|labels|names|fields|text|session|table)\.py$"
    r"|/(isolated|records)\.py$"
)
KINDS = ("sign", "sum", "product", "constant", "sine", "comparison", "index", "conjugate")
TOKENS = {
    ast.Add: ("sum", "+", "-"),
    ast.Sub: ("sum", "-", "+"),
    ast.Mult: ("product", "*", "/"),
    ast.Div: ("product", "/", "*"),
    ast.Lt: ("comparison", "<", ">="),
    ast.LtE: ("comparison", "<=", ">"),
    ast.Gt: ("comparison", ">", "<="),
    ast.GtE: ("comparison", ">=", "<"),
}
WORDS = {"sin": ("sine", "cos"), "cos": ("sine", "sin"), "conj": ("conjugate", "copy")}
SECONDS = 1800.0  # more than a package's tests take: a change may make a loop endless
# Changes that no test can notice, by what they are without their place: why.
EQUIVALENT = {
    "geometry/shapes.py: + -> - in return np.asarray((low * MOST_NODES + middle) * MOST_NODES + high)": (
        "facets are only told apart by this number, and different ones have different numbers either way"
    ),
    "geometry/sizes.py: * -> / in beyond = np.maximum(np.abs(z - 0.5 * (start + end)) - 0.5 * (end - start), "
    "0.0)": (
        "of journals shorter than their diameter only a field more is added, which asks for no smaller "
        "elements than the map does"
    ),
    "fem/solver.py: 0 -> 1 in count, starts = upper.shape[0], upper.indptr[:-1]": (
        "the matrix is square"
    ),
}


@dataclass(frozen=True)
class Change:
    """One token of a file, between two bytes of it, and what takes its place."""

    kind: str
    path: str
    line: int
    column: int
    text: str
    start: int
    old: str
    new: str

    def __str__(self) -> str:
        return f"{self.path}:{self.line}:{self.column + 1}: {self.old} -> {self.new} in {self.text}"

    @property
    def reason(self) -> str:
        """Why no test can notice it; "" if one can."""
        return EQUIVALENT.get(f"{self.path}: {self.old} -> {self.new} in {self.text}", "")

    def applied(self, source: bytes) -> bytes:
        """The file's content with the change."""
        end = self.start + len(self.old)
        return source[: self.start] + self.new.encode() + source[end:]


class _Finder:
    """The changes that one file allows."""

    def __init__(self, path: Path) -> None:
        self.path, self.source = path.relative_to(ROOT).as_posix(), path.read_bytes()
        self.lines = self.source.splitlines(keepends=True)
        self.starts = [0]
        for line in self.lines:
            self.starts.append(self.starts[-1] + len(line))

    def changes(self) -> Iterator[Change]:
        for function in ast.walk(ast.parse(self.source)):
            if isinstance(function, ast.FunctionDef) and not (
                function.name == "__post_init__"
                or (isinstance(function.returns, ast.Name) and function.returns.id == "str")
            ):
                for statement in function.body:
                    yield from self._within(statement)

    def _within(self, node: ast.AST) -> Iterator[Change]:
        if isinstance(node, (ast.Raise, ast.FunctionDef, ast.JoinedStr)):
            return
        if isinstance(node, ast.If) and any(isinstance(one, ast.Raise) for one in node.body):
            return
        yield from self._at(node)
        for child in ast.iter_child_nodes(node):
            yield from self._within(child)

    def _at(self, node: ast.AST) -> Iterator[Change]:
        match node:
            case ast.BinOp(left, operator, right) if not (_listed(left) or _listed(right)):
                yield from self._operator(left, operator, right)
                for one in (left, right):
                    if isinstance(one, ast.Constant) and isinstance(one.value, (int, float)):
                        whole = isinstance(one.value, int)
                        new = one.value + 1 if whole else 2.0 * one.value or 1.0
                        yield self._change("constant", self._start(one), self._code(one), repr(new))
            case ast.Compare(left, [operator], [right]) if not isinstance(right, ast.Constant):
                yield from self._operator(left, operator, right)
            case ast.AugAssign(target, operator, value) if not _listed(value):
                yield from self._operator(target, operator, value)
            case ast.UnaryOp(ast.USub(), operand) if not isinstance(operand, ast.Constant):
                yield self._change("sign", self._start(node), "-", "+")
            case ast.Attribute(value, name) if name in WORDS:
                start = self._end(value) + self.source[self._end(value) :].index(name.encode())
                kind, new = WORDS[name]
                yield self._change(kind, start, name, new)
            case ast.Subscript(_, index):
                for one in index.elts if isinstance(index, ast.Tuple) else [index]:
                    if isinstance(one, ast.Constant) and type(one.value) is int:
                        new = str(one.value - 1 if one.value else 1)
                        yield self._change("index", self._start(one), str(one.value), new)

    def _operator(self, left: ast.expr, operator: ast.AST, right: ast.expr) -> Iterator[Change]:
        kind, old, new = TOKENS.get(type(operator), ("", "", ""))
        if kind:
            between = self.source[self._end(left) : self._start(right)]
            code = re.sub(rb"#.*", lambda found: b" " * len(found[0]), between)
            yield self._change(kind, self._end(left) + code.index(old.encode()), old, new)

    def _change(self, kind: str, start: int, old: str, new: str) -> Change:
        line = self.source[:start].count(b"\n")
        text, column = self.lines[line].decode().strip(), start - self.starts[line]
        return Change(kind, self.path, line + 1, column, text, start, old, new)

    def _code(self, node: ast.expr) -> str:
        return self.source[self._start(node) : self._end(node)].decode()

    def _start(self, node: ast.expr) -> int:
        return self.starts[node.lineno - 1] + node.col_offset

    def _end(self, node: ast.expr) -> int:
        return self.starts[(node.end_lineno or 0) - 1] + (node.end_col_offset or 0)


def _listed(node: ast.expr) -> bool:
    """Whether an operand is text or a list: these are put together, not added."""
    made = isinstance(node, (ast.JoinedStr, ast.List, ast.ListComp))
    return made or (isinstance(node, ast.Constant) and isinstance(node.value, str))


def possible(package: str) -> list[Change]:
    """All changes that a package's calculations allow."""
    files = sorted((ROOT / package).rglob("*.py"))
    return [
        one
        for path in files
        if not OTHER.search(path.as_posix())
        for one in _Finder(path).changes()
    ]


def chosen(count: int, seed: int) -> list[Change]:
    """As many of each package, the kinds in turn, one of a line; edits of other lines leave it as it is."""

    def place(change: Change) -> str:
        key = f"{seed} {change.path} {change.text} {change.column} {change.new}"
        return hashlib.sha256(key.encode()).hexdigest()

    made: list[Change] = []
    for package in PACKAGES:
        sites: dict[tuple[str, int], Change] = {}
        for one in sorted(possible(package), key=place):
            sites.setdefault((one.path, one.line), one)
        kinds = [[one for one in sites.values() if one.kind == kind] for kind in KINDS]
        order = [one for turn in range(count) for kind in kinds for one in kind[turn : turn + 1]]
        made += order[: count // len(PACKAGES)]
    return made


class _Copy:
    """The checkout's copy, in which one change at a time is tried."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder / "checkout"
        left_out = shutil.ignore_patterns(".*", "__pycache__", "*-results", "build", "dist")
        shutil.rmtree(self.folder, ignore_errors=True)
        shutil.copytree(ROOT, self.folder, ignore=left_out)

    def failed(self, change: Change) -> str:
        """The first test that fails with a change and passes without it; "" if none does."""
        path = self.folder / change.path
        source = path.read_bytes()
        try:
            self._write(path, change.applied(source))
            ran = next((ran for ran in self._runs(change) if ran), "")
        finally:
            self._write(path, source)
        if not ran or ran == "stopped":
            return ran
        again = self._pytest("-m", "", ran)
        if again:
            raise SystemExit(f"{again} fails without a change, too")
        return ran

    def _write(self, path: Path, source: bytes) -> None:
        path.write_bytes(source)
        # Compiled code is known by time in seconds and size: both may be those of the other content.
        for old in (path.parent / "__pycache__").glob(f"{path.stem}.*.pyc"):
            old.unlink()

    def _runs(self, change: Change) -> Iterator[str]:
        tests = self._ordered(change)
        yield self._pytest("-m", "not slow", *tests)
        yield self._pytest("-m", "slow and not further", *tests)

    def _ordered(self, change: Change) -> list[str]:
        """The package's test files, those first that import the module or are called alike."""
        package = change.path.partition("/")[0]
        module = change.path.removesuffix(".py").replace("/", ".")
        words = set(module.split("."))

        def far(test: Path) -> tuple[bool, int]:
            return module not in test.read_text(), -len(words & set(test.stem.split("_")))

        return [
            test.relative_to(self.folder).as_posix()
            for test in sorted((self.folder / f"tests/test_{package}").glob("test_*.py"), key=far)
        ]

    def _pytest(self, *arguments: str) -> str:
        """Run tests to the first failure; its name, "" if all pass, "stopped" if they do not end."""
        command = [sys.executable, "-m", "pytest", "-x", "-q", "-n", "0", "-p", "no:cacheprovider"]
        command += ["--tb=no", *arguments]
        paths = os.pathsep.join((str(self.folder), os.environ.get("PYTHONPATH", "")))
        try:
            done = subprocess.run(
                command,
                cwd=self.folder,
                env=os.environ | {"PYTHONPATH": paths},
                capture_output=True,
                text=True,
                timeout=SECONDS,
            )
        except subprocess.TimeoutExpired:
            return "stopped"
        if done.returncode in (0, 5):  # 5: no test has such a mark
            return ""
        pattern = r"^(?:FAILED|ERROR) (\S+?(?:\[.*?\])?)(?: - .*)?$"
        found = re.search(pattern, done.stdout, re.MULTILINE)
        if not found:
            raise SystemExit(f"pytest did not run:\n{done.stdout[-2000:]}{done.stderr[-2000:]}")
        return found[1]


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--count", type=int, default=40)
    parser.add_argument("--seed", type=int, default=26)
    parser.add_argument("--list", action="store_true", help="print the changes only")
    parser.add_argument("--again", action="store_true", help="try survivors again")
    given = parser.parse_args()
    changes = chosen(given.count, given.seed)
    if given.list:
        print("\n".join(str(change) for change in changes))
        return 0
    given.folder.mkdir(parents=True, exist_ok=True)
    kept = given.folder / "results.json"
    results: dict[str, str] = json.loads(kept.read_text()) if kept.is_file() else {}
    copy = _Copy(given.folder)
    for change in changes:
        name = str(change)
        if not change.reason and (name not in results or (given.again and not results[name])):
            results[name] = copy.failed(change)
            kept.write_text(json.dumps(results, indent=1))
        found = results.get(name)
        verdict = f"caught by {found}" if found else f"equivalent ({change.reason})"
        print(f"{verdict if found or change.reason else 'SURVIVED'}: {name}", flush=True)
    survived = [one for one in changes if not one.reason and not results[str(one)]]
    equivalent = sum(bool(one.reason) for one in changes)
    caught = len(changes) - equivalent - len(survived)
    print(f"{caught} of {len(changes)} changes are caught, {equivalent} are equivalent")
    return 1 if survived else 0


if __name__ == "__main__":
    sys.exit(main())
