"""Render off-screen in a separate process.

VTK ends its process if no OpenGL library can be loaded; in a separate process this costs only the
pictures.
"""

import re
import subprocess
from pathlib import Path
from typing import Any

from crankbase.calls import RESULT, CallProcess, Limits, ProcessLostError
from crankbase.errors import MissingLibraryError, RenderError
from crankbase.processes import start_child

UNRENDERED = "the pictures of the throw could not be rendered"
ADVICE = (
    f"{UNRENDERED}; on Debian or Ubuntu install the off-screen OpenGL library with: "
    "apt-get install libegl1"
)
# What VTK says before it ends its process, and what Python says of a package that is not there.
NO_OPENGL = re.compile(r"Failed to load EGL|OSMesa not found|lib(EGL|GL|OpenGL|OSMesa)\.so")
NO_PACKAGE = re.compile(r"^(?:ModuleNotFoundError|ImportError): (.+)$", re.MULTILINE)
TIME_LIMIT = 120.0  # [s]
# Of what a process has said, so much is looked at.
SAID = 20_000


class OffscreenProcess:
    """A function of ours that renders in the background.

    Parameters
    ----------
    function : str
        ``"module:name"``; called with the arguments and the folder.
    folder : Path
        A scratch folder, for what the function writes.
    *arguments
        Passed to the function.

    Raises
    ------
    OSError
        If the process cannot be started.
    """

    def __init__(self, function: str, folder: Path, *arguments: Any) -> None:
        self._said = folder / "said.txt"
        with self._said.open("wb") as errors:
            child = start_child(
                "crankbase.calls", stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=errors
            )
        self._process = CallProcess(child, "the process for it")
        self._process.give(function, *arguments, folder)

    def wait(self) -> None:
        """Wait for the pictures.

        Raises
        ------
        MissingLibraryError
            If a library is missing; the message names what to install.
        RenderError
            If they could not be made for another reason, which the message gives.
        """
        try:
            kind, content = self._process.wait(Limits(TIME_LIMIT))
        except ProcessLostError as error:
            errors = self._said.read_bytes()[-SAID:].decode(errors="replace")
            raise render_failure(str(error), errors) from None
        finally:
            self.stop()
        if kind != RESULT:
            raise render_failure(content)

    def stop(self) -> None:
        """End the rendering."""
        self._process.end()


def render_failure(reason: str, output: str = "") -> MissingLibraryError | RenderError:
    """Return the error with the reason why there are no pictures.

    Parameters
    ----------
    reason : str
        End of the process, or the error of its function.
    output : str
        What it wrote to standard error.
    """
    missing = NO_PACKAGE.findall(f"{output}\n{reason}")
    if NO_OPENGL.search(output):
        return MissingLibraryError(ADVICE)
    if missing:
        return MissingLibraryError(f"{UNRENDERED}: {missing[-1]}")
    # An exception's last line says what happened.
    last = next((line.strip() for line in reversed(output.splitlines()) if line.strip()), "")
    saying = f", saying: {last.rstrip('.')}" if last else ""
    return RenderError(f"{UNRENDERED}: {reason}{saying}.")
