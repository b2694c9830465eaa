import contextlib
import io
import re
import shlex
import shutil
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path

import pytest

from crankfem.analyses.throw.pictures import stress_picture
from crankfem.cli import app as cli
from crankfem.jobs.pipeline import RunResult, run_engine
from printed_text import difference
from puppets import stand_in_worker
from regression.runs import workers
from stand_ins import draw_nothing, lighten, put_everywhere

ROOT = Path(__file__).resolve().parents[2]
FENCE = re.compile(r"^(?P<indent> *)(?P<ticks>`{3,})(?P<language>[\w-]*)(?P<rest>.*)$")
TITLE = re.compile(r'title="([^"]+)"')
MARK = re.compile(r"<!-- not run:(.*)-->")
EXIT_CODE = re.compile(r"# exit code (\d+)")
WRITTEN = ("toml", "csv", "txt", "text", "json")


@dataclass(frozen=True)
class Block:
    """A fenced block of a page."""

    line: int  # of its opening fence, from 1
    language: str
    title: str | None
    text: str
    not_run: str | None = None  # the reason


def blocks_of(text):
    """Return the fenced blocks of a page's text in order."""
    found, lines, number, reason = [], text.splitlines(), 0, None
    while number < len(lines):
        line = lines[number]
        opening = FENCE.match(line)
        if opening is None:
            mark = MARK.fullmatch(line.strip())
            if mark is not None:
                reason = mark[1].strip()
                assert reason, f"line {number + 1}: a block that is not run needs a reason"
            elif line.strip():
                assert reason is None, f"line {number + 1}: 'not run' stands right before a block"
            number += 1
            continue
        indent, ticks = len(opening["indent"]), opening["ticks"]
        inside = lines[number + 1 :]
        length = next((i for i, inner in enumerate(inside) if inner.strip() == ticks), None)
        assert length is not None, f"line {number + 1}: this block has no end"
        title = TITLE.search(opening["rest"])
        found.append(
            Block(
                line=number + 1,
                language=opening["language"],
                title=title[1] if title else None,
                text="".join(f"{inner[indent:]}\n" for inner in inside[:length]),
                not_run=reason,
            )
        )
        number, reason = number + length + 2, None
    assert reason is None, "'not run' stands right before a block"
    return found


def commands_of(text):
    """Return the lines of a shell block that call crankfem: words, exit code, file of the output."""
    for line in text.replace("\\\n", " ").splitlines():
        words = shlex.split(line, comments=True)
        if words[:1] != ["crankfem"]:
            continue
        target = None
        if ">" in words:
            assert words.index(">") == len(words) - 2, f"{line}: what comes after '>'?"
            *words, _, target = words
        # Quoted words may hold such signs; alone they would ask for a shell.
        assert not set(words) & {"|", "&&", "||", ";", "&", "<", ">>"}, f"{line}: not run so"
        code = EXIT_CODE.search(line)
        yield words[1:], int(code[1]) if code else 0, target


# ----------------------------------------------------------------------------------- light machinery

# Folders of runs by what they were made of: several pages run the same shipped engine. They are copies,
# for a test's own folder is gone after it.
finished_runs = {}
kept_folders = tempfile.TemporaryDirectory()


def run_once(engine, output=None, **options):
    """Run an engine, or copy what the same file has given to another page."""
    path = Path(engine)
    if not path.is_file():
        return run_engine(engine, output, **options)
    beside = [path, *sorted(path.parent.glob("*.csv"))]
    key = (path.stem, tuple((one.name, one.read_bytes()) for one in beside))
    if key not in finished_runs:
        found = run_engine(engine, output, **options)
        kept = Path(kept_folders.name, str(len(finished_runs)))
        shutil.copytree(found.folder, kept)
        finished_runs[key] = RunResult(kept, found.report, found.results)
        return found
    first = finished_runs[key]
    folder = Path(output) if output is not None else Path(f"{path.stem}-results")
    shutil.copytree(first.folder, folder, dirs_exist_ok=True)
    return RunResult(folder, folder / first.report.name, first.results)


class Runner:
    """Runs the blocks of one page in its folder and in one namespace."""

    def __init__(self, page, folder, monkeypatch):
        self.page, self.folder, self.monkeypatch = page, folder, monkeypatch
        self.names = {"__name__": "__main__"}

    def run(self, blocks):
        """Run them all; return how many were run or written."""
        count, printed = 0, None
        for block in blocks:
            place = f"{self.page.name}, line {block.line}"
            if block.language == "text" and not block.title:
                if printed and not block.not_run:
                    differs = difference(block.text.rstrip(), printed.rstrip())
                    assert not differs, f"{place} shows and the block above prints:\n{differs}"
                printed = None
                continue
            printed = None
            if block.not_run:
                continue
            if block.language == "python":
                printed = self._execute(block)
            elif block.language == "sh":
                for words, code, target in commands_of(block.text):
                    self._call(words, code, target, place)
            elif block.title and block.language in WRITTEN:
                path = self.folder / block.title
                assert path.resolve().is_relative_to(self.folder.resolve()), place
                path.parent.mkdir(parents=True, exist_ok=True)
                path.write_text(block.text, encoding="utf-8")
            else:
                continue
            count += 1
        return count

    def _execute(self, block):
        # Empty lines in front, so that a traceback names the line of the page.
        code = compile("\n" * block.line + block.text, str(self.page), "exec")
        with contextlib.redirect_stdout(io.StringIO()) as printed:
            exec(code, self.names)
        return printed.getvalue()

    def _call(self, words, code, target, place):
        out, err = io.StringIO(), io.StringIO()
        with self.monkeypatch.context() as patch:
            patch.setattr(sys, "argv", ["crankfem", *words])
            patch.setattr(workers, "spawn_worker", stand_in_worker)
            patch.setattr("crankfem.jobs.pipeline.run_engine", run_once)
            draw_nothing(patch)
            with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
                try:
                    cli.main()
                    ended = 0
                except SystemExit as error:
                    ended = error.code or 0
        said = f"{place}: crankfem {shlex.join(words)}\n{out.getvalue()[-2000:]}\n{err.getvalue()}"
        assert ended == code, f"{said}\nended with {ended}"
        if target is not None:
            (self.folder / target).write_text(out.getvalue(), encoding="utf-8")


@pytest.fixture
def run_page(monkeypatch, tmp_path):
    """Run a page's blocks in an empty folder: analyses shared, stresses coarse, nothing rendered."""
    monkeypatch.chdir(tmp_path)
    lighten(monkeypatch)
    put_everywhere(monkeypatch, stress_picture.picture_stresses, lambda *_: ())

    def run(page):
        blocks = blocks_of(page.read_text(encoding="utf-8"))
        return Runner(page, tmp_path, monkeypatch).run(blocks)

    return run


@pytest.fixture(scope="session")
def root():
    return ROOT


@pytest.fixture(scope="session")
def page_tools():
    """Take a page apart: its blocks, the commands of a block."""
    return blocks_of, commands_of
