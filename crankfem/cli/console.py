"""Output of the command line: tables on standard output, progress and errors on standard error."""

import os
import re
import sys
import time
import traceback
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager, suppress
from itertools import pairwise
from pathlib import Path
from typing import TYPE_CHECKING, Any, NoReturn, TypeVar

from rich.console import Console
from rich.text import Text

from crankbase.errors import InputError, first_sentences, visible, with_short_quotes
from crankbase.sentences import kept
from crankbase.table import SI, Main, MainWarning, OutputUnits, Table
from crankbase.written_quantity import split_quantity
from crankfem.cli.interrupts import interrupted_sentence, interrupts_raise
from crankfem.cli.layout import Line, legend, short_ways, table_lines, wrapped
from crankfem.jobs.exit_codes import (
    EXIT_INPUT,
    EXIT_INTERRUPTED,
    EXIT_PIPE,
    TRACEBACK,
    describe_error,
)

if TYPE_CHECKING:
    from rich.progress import TaskID

    from crankbase.array_checks import Array
    from crankbase.results import Result
    from regression.records import Outcome

Value = TypeVar("Value")
# Lines of the first screen, and rows that a table on it keeps.
LINES, FEWEST_ROWS = 40, 4
MICROMETERS = re.compile(r"(?<=\d )um\b|(?<=\[)um(?=\])")
# Seconds between two lines of progress where no bar can be drawn.
LINE_EVERY = 30.0
# With what rich and typer end where the output is read no more.
UNREAD = 1


class Terminal(Console):
    """A stream of the terminal: texts are shown as they are, and control nothing.

    Attributes
    ----------
    printed : int
        Lines of the paragraphs of this command so far.
    not_used : list of str or None
        What the command does not use of its file, for JSON; None without a file.
    units : OutputUnits
        Of the command's results, for what ends it.
    """

    printed = 0
    not_used: "list[str] | None" = None
    units: OutputUnits = SI

    def render_str(self, text: str, **options: Any) -> Text:
        """Return a text for display."""
        if self.encoding.startswith("utf"):
            text = MICROMETERS.sub("\N{MICRO SIGN}m", text)
        return super().render_str(visible(text), **options)

    def paragraph(self, text: str) -> None:
        """Print a paragraph, wrapped between words in a terminal, in one line where another program reads."""
        lines = wrapped(text, self.width)
        self.printed += len(lines)
        whole = not (self.is_terminal or "COLUMNS" in os.environ)
        self.print(text if whole else "\n".join(lines), soft_wrap=True, highlight=False)


# Brackets and colons in units and names are text, neither markup nor pictures.
errors = Terminal(stderr=True, markup=False, emoji=False)
output = Terminal(markup=False, emoji=False)


def print_json(content: "dict[str, Any] | Result") -> None:
    """Print JSON content with the units of its numbers, and nothing else, on standard output."""
    from crankbase.results import json_text
    from crankfem.analyses.record import with_units

    record = with_units(content)
    if output.not_used is not None:
        record["not_used"] = output.not_used
    sys.stdout.write(json_text(record, indent=1))


def print_line(text: str) -> None:
    """Print one paragraph."""
    output.paragraph(text)


def print_path(text: str) -> None:
    """Print one line that is never wrapped, such as one that ends in a path."""
    output.print(text, soft_wrap=True, highlight=False)


def print_warning(text: str) -> None:
    """Print on standard error that data are lost, or input looks wrong, which --quiet does not hide."""
    print_note(f"Warning: {text}")


def print_warnings(warnings: Iterable[str], units: OutputUnits = SI) -> None:
    """Print what looks wrong in the input, each as a warning."""
    for warning in warnings:
        print_warning(units.written(f"{kept(warning).rstrip('.')}."))


def print_note(text: str, quiet: bool = False) -> None:
    """Print a note on standard error, unless --quiet is given."""
    if not quiet:
        errors.paragraph(text)


def print_table(table: Table) -> None:
    """Print a table and its note."""
    print_parts([table])


def print_parts(
    parts: Iterable[Table | str],
    units: OutputUnits = SI,
    answers: Sequence[Table | str] = (),
    *,
    full: bool = True,
) -> None:
    """Print tables and paragraphs, and below them the answers.

    Unless `full`, only the main parts are printed, as far as one screen has room: first, paragraphs are cut
    to their first sentences, then rows of tables are left out, then parts, the last ones first, but warnings
    only where nothing else is left, and answers never.
    """
    shown = [*parts, *answers] if full else _first_screen(list(parts), list(answers), units)
    blocks = [_lines(part, units) for part in shown]
    explained = legend("\n".join(line for lines in blocks for line, _ in lines))
    for number, (part, lines) in enumerate(zip(shown, blocks, strict=True)):
        if number and not (isinstance(part, str) and isinstance(shown[number - 1], str)):
            output.paragraph("")
        if isinstance(part, str):
            output.paragraph(short_ways(part))
        else:
            for line, style in lines:
                output.print(line, style=style, soft_wrap=True, highlight=False)
        if explained and legend("\n".join(line for line, _ in lines)):
            output.paragraph(explained)
            explained = ""


def _lines(part: Table | str, units: OutputUnits) -> list[Line]:
    if isinstance(part, str):
        return [(line, "") for line in wrapped(short_ways(part), output.width)]
    return table_lines(part, units, output.width)


def _first_screen(
    parts: list[Table | str], answers: list[Table | str], units: OutputUnits
) -> list[Table | str]:
    """Return the main parts, as many and with so many rows as one screen holds, and the answers."""
    main: list[Table | str] = []
    for part in parts:
        if isinstance(part, Main):
            main.append(part)
        elif not isinstance(part, str) and part.main:
            main.append(part.combined(units))
    room = LINES - output.printed - errors.printed
    every = Counter(map(_kind, parts)) + Counter({"row": sum(map(_rows, main))})
    while True:
        known = Counter(map(_kind, main)) + Counter({"row": sum(map(_rows, main))})
        more = sorted((every - known).items(), reverse=True)
        left = ", ".join(f"{count} more {name}{'s' * (count > 1)}" for name, count in more)
        hint: list[Table | str] = [f"With --full: {left}."] if left else []
        shown = [*main, *hint, *answers]
        # The lines of the parts, with those between them and that of the legend.
        apart = sum(not all(isinstance(part, str) for part in pair) for pair in pairwise(shown))
        excess = 1 + apart + sum(len(_lines(part, units)) for part in shown) - room
        if not main or excess <= 0:
            return shown
        leads = [part.lead if isinstance(part, Main) else part for part in main]
        if leads != main:
            main = leads
            continue
        longest = max(main, key=lambda part: (_rows(part) > FEWEST_ROWS, len(_lines(part, units))))
        if not isinstance(longest, str) and _rows(longest) > FEWEST_ROWS:
            kept = max(FEWEST_ROWS, _rows(longest) - 1 - excess // 4)
            main[main.index(longest)] = longest.heaviest(kept)
        else:
            places = [place for place, part in enumerate(main) if not isinstance(part, MainWarning)]
            del main[places[-1] if places else -1]


def _kind(part: Table | str) -> str:
    return "remark" if isinstance(part, str) else "table"


def _rows(part: Table | str) -> int:
    return 0 if isinstance(part, str) else len(part.rows)


def print_notes(remarks: Iterable[str]) -> None:
    """Print remarks, each as a note."""
    for remark in remarks:
        print_line(f"Note: {remark}")


@contextmanager
def clear_errors() -> Iterator[None]:
    """End with one sentence and an exit code instead of a traceback.

    The codes are those of `crankfem.jobs.exit_codes`. With the environment variable CRANKFEM_TRACEBACK the
    traceback of any exit is printed before the sentence.
    """
    errors.units = SI
    try:
        yield
        sys.stdout.flush()
    except KeyboardInterrupt:
        errors.print(interrupted_sentence(), soft_wrap=True)
        raise SystemExit(EXIT_INTERRUPTED) from None
    except BrokenPipeError:
        _exit_broken_pipe()
    except SystemExit as end:
        # Typer turns an interrupt of a command into this code, without a word.
        if end.code == EXIT_INTERRUPTED and not isinstance(end, ReportedExit):
            errors.print(interrupted_sentence(), soft_wrap=True)
        # Nothing here ends so; rich and typer do where nobody reads the output any more.
        if end.code == UNREAD:
            _exit_broken_pipe()
        raise
    except Exception as error:
        if os.environ.get(TRACEBACK):
            errors.print(traceback.format_exc(), soft_wrap=True, highlight=False)
        message, code = describe_error(error)
        _stop(message, code)


class ReportedExit(SystemExit):
    """An exit whose reason has been reported."""


def exit_interrupted(sentence: str) -> NoReturn:
    """Exit after an interrupt, with a given sentence."""
    errors.print(sentence, soft_wrap=True)
    raise ReportedExit(EXIT_INTERRUPTED)


def exit_usage_error(sentence: str, command: str) -> NoReturn:
    """Exit because of a usage error on the command line, with a reference to the help."""
    read = f"see `{command}`."
    if sentence.endswith("?"):
        _stop(f"{sentence} {read.capitalize()}", EXIT_INPUT)
    _stop(f"{sentence.rstrip('.')}; {read}", EXIT_INPUT)


def exit_by_verdict(sentence: str, code: int) -> NoReturn:
    """Exit because the verdict, with --strict, is not acceptable."""
    errors.print(sentence, soft_wrap=True, highlight=False)
    raise ReportedExit(code)


def _exit_broken_pipe() -> NoReturn:
    """Exit silently: the reader of the output has ended."""
    # What is still buffered goes nowhere, so that Python has nothing to complain of at its end.
    with suppress(OSError, ValueError):
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
    raise SystemExit(EXIT_PIPE)


def _stop(message: str, code: int) -> NoReturn:
    # Several errors of a file stand below each other.
    # A limit is to be typed as it stands here.
    lines = (errors.units.written(line, full=True) for line in first_sentences(message))
    sentence = "\n       ".join(map(with_short_quotes, lines))
    errors.print(Text("Error:", "bold red"), sentence, soft_wrap=True, highlight=False)
    raise SystemExit(code)


class RunProgress:
    """Steps of a run and a bar for its study, on standard error; with `quiet` warnings alone are shown."""

    def __init__(self, quiet: bool = False) -> None:
        from rich.progress import BarColumn, MofNCompleteColumn, Progress, SpinnerColumn, TextColumn
        from rich.progress import TimeElapsedColumn as Elapsed

        self._quiet = quiet
        self._raising = ExitStack()
        self._bar = Progress(
            SpinnerColumn(),
            TextColumn("{task.description}", markup=False),
            BarColumn(),
            MofNCompleteColumn(),
            Elapsed(),
            TextColumn("{task.fields[pace]}", markup=False),
            console=errors,
            disable=quiet,
            # Its lines would take the room of the results.
            transient=errors.is_terminal,
        )
        self._task: TaskID | None = None
        # Designs finished now and before this run, and all of them.
        self.finished, self._before, self.total = 0, 0, 0
        self._began = self._said = time.monotonic()

    def __enter__(self) -> "RunProgress":
        # Work with progress holds a store or processes open, which an interrupt must let close.
        self._raising.enter_context(interrupts_raise())
        self._bar.start()
        return self

    def __exit__(self, kind: type[BaseException] | None, *_: object) -> None:
        if kind is not None and self._task is not None:
            self._bar.update(self._task, visible=False)
        self._bar.stop()
        self._raising.close()

    @property
    def finished_designs(self) -> str:
        """How many designs of the study are finished."""
        return f"{self.finished} of {self.total} designs"

    def step(self, text: str) -> None:
        """Name the step that begins, and count the last one as done."""
        if self._task is not None:
            task = self._bar.tasks[-1]
            self._bar.update(self._task, completed=task.total, refresh=True)
        self._task = self._bar.add_task(visible(text), total=1, pace="")

    def design(self, finished: int, total: int, newest: "Outcome | None") -> None:
        """Advance the bar; report the pace, and a failed design."""
        now = time.monotonic()
        if newest is None:
            self._before, self._began, self._said = finished, now, now
        self.finished, self.total = finished, total
        shown = progress_text(finished - self._before, now - self._began, total - finished)
        if self._task is not None:
            self._bar.update(self._task, completed=finished, total=total, pace=shown, refresh=True)
        if newest is not None and newest.reason is not None:
            fate = "lost, to be tried again by the next run" if newest.lost else "failed"
            tell = self.warn if newest.lost else self.note
            tell(f"design {newest.key[:6]} {fate}: {newest.reason}")
        if not self._quiet and not errors.is_terminal and now - self._said >= LINE_EVERY:
            self._said = now
            errors.print(f"{finished} of {total} designs, {shown}", soft_wrap=True)

    def note(self, text: str) -> None:
        """Print a remark above the bar."""
        print_note(f"Note: {text}", self._quiet)

    def warn(self, text: str) -> None:
        """Print above the bar what is lost, or looks wrong in the input, with `quiet` too."""
        print_warning(text)

    def finish(self) -> None:
        """Count the last step as done."""
        if self._task is not None:
            self._bar.update(self._task, completed=self._bar.tasks[-1].total, refresh=True)


def progress_text(finished: int, seconds: float, left: int) -> str:
    """State the pace of designs, and the time left.

    Examples
    --------
    >>> progress_text(10, 60.0, 190)
    '10 designs/min, 19 min left'
    """
    if finished < 1 or seconds <= 0.0:
        return ""
    rate = finished / seconds
    text, minutes = f"{60.0 * rate:.3g} designs/min", left / rate / 60.0
    if left == 0:
        return text
    if minutes < 1.5:
        return f"{text}, {60.0 * minutes:.0f} s left"
    return f"{text}, {f'{minutes:.0f} min' if minutes < 90.0 else f'{minutes / 60.0:.1f} h'} left"


def number(value: float, digits: int = 4) -> str:
    """Write a number with so many significant digits."""
    return f"{value:.{digits}g}"


def parse_pairs(
    pairs: Iterable[str], convert: Callable[[str, str], Value], example: str = "web_width=300mm"
) -> dict[str, Value]:
    """Read name=value pairs from the command line; `example` is used in the message."""
    values: dict[str, Value] = {}
    texts = list(pairs)
    apart = split_quantity(texts)
    if apart is not None:
        pair, unit = apart
        raise InputError(
            f"{pair.partition('=')[0]}: given {pair} and {unit} as two words; write number and unit as one, "
            f'{pair}{unit}, or in quotes, "{pair} {unit}".'
        )
    for pair in texts:
        name, equals, text = pair.partition("=")
        if not equals or not name.strip():
            raise InputError(f"{pair}: given without a value; write name=value, like {example}.")
        if name.strip() in values:
            raise InputError(f"{name.strip()}: given twice; give it once.")
        values[name.strip()] = convert(name.strip(), text)
    return values


def write_columns(path: Path, columns: "Mapping[str, Array]", heading: str = "") -> None:
    """Write columns of equal length to 12 digits, units in their names; see `write_rows`."""
    from crankfem.jobs.outputs import write_rows  # here: most commands write no table

    rows = zip(*(column.tolist() for column in columns.values()), strict=True)
    write_rows(path, list(columns), ([f"{value:.12g}" for value in row] for row in rows), heading)
