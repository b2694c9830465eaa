"""Run CalculiX on a deck of ours, and read what it says of the end sections."""

import os
import re
import shutil
import subprocess
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from crankbase.errors import InputError, MissingLibraryError
from fem.calculix import ENDS

Array = NDArray[np.float64]

PROGRAM = "ccx"


class CalculixError(RuntimeError):
    """CalculiX did not finish, or what it wrote cannot be read; the message says why."""


@dataclass(frozen=True)
class EndResults:
    """What CalculiX found for both end sections in one step.

    Attributes
    ----------
    motions : (12,) array
        ux uy uz [m] rx ry rz [rad] of the left, then of the right end section's center.
    forces : (12,) array
        All outer forces [N] and moments [N m] on them: reactions of the supports and end loads.
    """

    motions: Array
    forces: Array


def run_calculix(
    deck: str | Path, threads: int = 2, time_limit: float = 600.0, *, program: str = PROGRAM
) -> Path:
    """Run CalculiX on a deck, in the deck's folder.

    Parameters
    ----------
    deck : path
        The ``.inp`` file.
    threads : int
        Of assembly and equation solver.
    time_limit : float
        Seconds after which it is ended.
    program : str
        Name or path of the program.

    Returns
    -------
    Path
        The ``.dat`` file with the printed results, for `read_calculix`.

    Raises
    ------
    MissingLibraryError
        If the program is not installed.
    InputError
        If there is no such deck.
    CalculixError
        If it fails, crashes or takes too long.
    """
    deck = Path(deck).absolute()
    if deck.suffix != ".inp" or not deck.is_file():
        raise InputError(
            f"deck: given {deck}; allowed is a file with the ending '.inp', because CalculiX reads no "
            "other."
        )
    found = shutil.which(program)
    if found is None:
        raise MissingLibraryError(
            f"CalculiX ({program}) is not installed; install it with: apt-get install calculix-ccx"
        )
    results = deck.with_suffix(".dat")
    # What an earlier run left must never be taken for this one's results.
    results.unlink(missing_ok=True)
    asked = {"OMP_NUM_THREADS": str(threads), "CCX_NPROC_EQUATION_SOLVER": str(threads)}
    try:
        done = subprocess.run(
            [Path(found).absolute(), "-i", deck.stem],
            cwd=deck.parent,
            env=os.environ | asked,
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            encoding="utf-8",
            errors="replace",
            timeout=time_limit,
            check=False,
        )
    except subprocess.TimeoutExpired:
        raise CalculixError(f"CalculiX took more than {time_limit:g} s for {deck.name}.") from None
    if done.returncode != 0 or "Job finished" not in done.stdout or not results.is_file():
        raise CalculixError(
            f"CalculiX ended with code {done.returncode} on {deck.name}: {_error_text(done.stdout)}"
        )
    return results


def read_calculix(results: str | Path) -> tuple[EndResults, ...]:
    """Read motions and outer forces of the end sections from the ``.dat`` file of our deck.

    Parameters
    ----------
    results : path

    Returns
    -------
    tuple of EndResults
        One for each step, of 7 digits as they are printed.

    Raises
    ------
    CalculixError
        If the file cannot be read or does not hold them.
    """
    results = Path(results)
    try:
        text = results.read_text(encoding="utf-8", errors="replace")
    except OSError as error:
        raise CalculixError(f"{results}: cannot be read ({error.strerror or error}).") from None
    tables = {
        kind: [
            _end_values(rows, results)
            for rows in re.findall(
                rf"^ *{kind} \([^)]*\) for set {ENDS} and time .*\n\s*\n((?: *\d+ .*\n?)+)",
                text,
                re.M,
            )
        ]
        for kind in ("displacements", "forces")
    }
    motions, forces = tables.values()
    if not motions or len(motions) != len(forces):
        raise CalculixError(
            f"{results}: has {len(motions)} tables of displacements and {len(forces)} of forces for the "
            f"set {ENDS}; a finished run of our deck has one of each for every step."
        )
    return tuple(EndResults(*found) for found in zip(motions, forces, strict=True))


def _end_values(rows: str, results: Path) -> Array:
    """Take the four nodes' three values each out of a printed table."""
    try:
        values = np.array(
            [[float(field) for field in row.split()[1:]] for row in rows.splitlines()]
        )
    except ValueError:
        values = np.empty(0)
    if values.shape != (4, 3) or not np.all(np.isfinite(values)):
        raise CalculixError(
            f"{results}: a table holds not four nodes with three numbers each: {rows}"
        )
    return values.ravel()


def _error_text(output: str) -> str:
    """CalculiX's first error with the line after it, or its last words."""
    lines = [line.strip() for line in output.splitlines() if line.strip()]
    for number, line in enumerate(lines):
        if "*ERROR" in line:
            return " ".join(lines[number : number + 2])
    return " ".join(lines[-2:]) or "it said nothing."
