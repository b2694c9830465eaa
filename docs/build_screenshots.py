"""Make the pictures of the report and of the command line with the current code: a minute or two.

Run it in a checkout, after what the report or the commands print has changed:

    .venv/bin/pip install -e '.[browser,docs]'
    .venv/bin/python docs/build_screenshots.py            # all
    .venv/bin/python docs/build_screenshots.py commands   # docs/screens/*.svg alone
    .venv/bin/python docs/build_screenshots.py report     # docs/report.png, docs/screens/*.png

The report's pictures need Debian's chromium (another program: CHROMIUM=/path/to/it). Commands run in a
terminal of 100 columns, as a reader would see them.
"""

import contextlib
import fcntl
import os
import pty
import re
import struct
import subprocess
import sys
import termios
from pathlib import Path

from rich.console import Console
from rich.terminal_theme import TerminalTheme
from rich.text import Text

HERE = Path(__file__).resolve().parent
ROOT = HERE.parent
SCREENS = HERE / "screens"
KEPT = ROOT / "build" / "screens"  # the study's designs are computed once
COLUMNS, LINES = 80, 50
MODULE = "from crankfem.cli.entry import main; main()"
ENGINE = "6chn25-34"
# Names of pictures, and commands.
COMMANDS = {
    "check": "crankfem check mine.toml",
    "run": "crankfem run mine.toml",
    "lookup": "crankfem lookup mine-results/model.json web_width=300mm web_thickness=72mm pin_length=139mm",
    "vibration": "crankfem vibration mine.toml",
}
# The report's colors, on a light ground.
THEME = TerminalTheme(
    (250, 251, 252),
    (29, 39, 51),
    [
        (29, 39, 51),
        (182, 59, 59),
        (47, 122, 77),
        (168, 98, 28),
        (31, 95, 153),
        (122, 91, 166),
        (26, 122, 138),
        (91, 104, 117),
    ],
    [
        (91, 104, 117),
        (182, 59, 59),
        (47, 122, 77),
        (168, 98, 28),
        (31, 95, 153),
        (122, 91, 166),
        (26, 122, 138),
        (29, 39, 51),
    ],
)
# Terminals move the cursor while progress is shown; only what stays is wanted.
ERASED = re.compile(r"\x1b\[[0-9;]*[ABCDHJKfnsu]|\x1b\[\?[0-9;]*[hl]")


def terminal_output(arguments: list[str], folder: Path) -> str:
    """Run crankfem in a pseudo-terminal and return its standard output with colors.

    Progress and notes go to standard error, which is not shown.
    """
    ours, theirs = pty.openpty()
    fcntl.ioctl(theirs, termios.TIOCSWINSZ, struct.pack("HHHH", LINES, COLUMNS, 0, 0))
    paths = [str(ROOT), *filter(None, os.environ.get("PYTHONPATH", "").split(os.pathsep))]
    environment = os.environ | {
        "COLUMNS": str(COLUMNS),
        "COLORTERM": "truecolor",
        "PYTHONPATH": os.pathsep.join(paths),
        "TERM": "xterm-256color",
    }
    environment.pop("NO_COLOR", None)
    # The command's name is that of its first argument: help shows it.
    code = f"import sys; sys.argv[0] = 'crankfem'; {MODULE}"
    process = subprocess.Popen(
        [sys.executable, "-c", code, *arguments],
        cwd=folder,
        env=environment,
        stdin=subprocess.DEVNULL,
        stdout=theirs,
        stderr=subprocess.PIPE,
    )
    os.close(theirs)
    found = bytearray()
    with contextlib.suppress(OSError):  # a terminal whose other end is closed reads as an error
        while piece := os.read(ours, 65536):
            found += piece
    os.close(ours)
    told = process.communicate()[1]
    if process.returncode != 0:
        sys.exit(f"crankfem {' '.join(arguments)} ended with {process.returncode}: {told.decode()}")
    return ERASED.sub("", found.decode("utf-8").replace("\r\n", "\n"))


def save_screen(path: Path, command: str, output: str) -> None:
    """Write a picture of a terminal: the command and what it printed."""
    console = Console(
        record=True,
        width=COLUMNS,
        file=open(os.devnull, "w", encoding="utf-8"),  # noqa: SIM115
        force_terminal=True,
        color_system="truecolor",
    )
    console.print(Text.assemble(("$ ", "bold blue"), (command, "bold")), soft_wrap=False)
    console.print(Text.from_ansi(output.strip("\n")))
    svg = console.export_svg(title="", theme=THEME, unique_id=f"screen-{path.stem}")
    # The template loads a font from elsewhere; any typewriter font does.
    svg = re.sub(r"\s*@font-face \{.*?\}", "", svg, flags=re.DOTALL)
    svg = re.sub(
        r"font-family: [^;]*;", "font-family: Menlo, Consolas, 'DejaVu Sans Mono', monospace;", svg
    )
    svg = "\n".join(line.rstrip() for line in svg.splitlines())
    path.write_text(f"{svg}\n", encoding="utf-8")


def make_engine_file(folder: Path) -> None:
    """Make the file that all pictures are of."""
    (folder / "mine.toml").unlink(missing_ok=True)
    terminal_output(["new", "mine.toml", "--from", ENGINE], folder)


def make_commands(folder: Path) -> None:
    """Run the commands one after another in one folder."""
    SCREENS.mkdir(exist_ok=True)
    make_engine_file(folder)
    for name, command in COMMANDS.items():
        print(command, flush=True)
        output = terminal_output(command.split()[1:], folder)
        save_screen(SCREENS / f"{name}.svg", command, output)


def make_report(folder: Path) -> None:
    """Photograph the first screen of the report, and its view of the throw."""
    from playwright.sync_api import sync_playwright

    make_engine_file(folder)
    results = folder / "mine-results"
    print("crankfem run mine.toml", flush=True)
    terminal_output(["run", "mine.toml"], folder)
    SCREENS.mkdir(exist_ok=True)
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(
            executable_path=os.environ.get("CHROMIUM", "/usr/bin/chromium"),
            # Machines without a graphics card draw the three-dimensional view by software.
            args=[
                "--no-sandbox",
                "--disable-background-networking",
                "--use-gl=angle",
                "--use-angle=swiftshader",
                "--enable-unsafe-swiftshader",
            ],
        )
        page = browser.new_page(viewport={"width": 1280, "height": 800}, device_scale_factor=1.5)
        page.goto((results / "report.html").as_uri())
        page.wait_for_timeout(1500)
        page.screenshot(path=HERE / "report.png")
        page.locator("#throw > details > summary").click()
        view = page.locator("[data-plot=throw_view]")
        if view.count():
            view.first.evaluate(
                "element => (element.closest('figure') || element).scrollIntoView()"
            )
            with contextlib.suppress(Exception):
                view.first.wait_for(state="visible", timeout=20_000)
            page.wait_for_timeout(4000)
            view.first.evaluate_handle(
                "element => element.closest('figure') || element"
            ).as_element().screenshot(path=SCREENS / "throw_view.png")
        else:
            print(
                "the report has no throw_view: docs/screens/throw_view.png is not made", flush=True
            )
        browser.close()


def main() -> None:
    """Make what is asked for, or all."""
    wanted = sys.argv[1:] or ["commands", "report"]
    makers = {"commands": make_commands, "report": make_report}
    unknown = sorted(set(wanted) - set(makers))
    if unknown:
        sys.exit(f"{unknown[0]}: allowed is {' or '.join(makers)}")
    KEPT.mkdir(parents=True, exist_ok=True)
    for name in wanted:
        makers[name](KEPT)


if __name__ == "__main__":
    main()
