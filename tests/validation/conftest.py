"""Figures: what a validation test finds, beside what it should find and how far off it may be.

``figure`` stands in place of an assertion, so that the number that is shown is the number that is
tested. ``pytest tests/validation -m "" --figures docs/validation-figures.json`` keeps them for
docs/build_validation.py, which makes docs/validation.md of them.
"""

import datetime
import importlib.metadata
import json
import platform
from pathlib import Path

import numpy as np
import pytest

LIBRARIES = ("numpy", "scipy", "scikit-fem", "gmsh")
RECORDED = "figures"


def compared(what, found, reference, allowed, unit="", kind="relative", scale=None):
    """Compare and return the place where both differ most; AssertionError if that is not allowed.

    Numbers of one name within a test are one figure, the worst of them.

    Parameters
    ----------
    what : str
        Of what the numbers are, as the page shall call it.
    found, reference : array_like
        Of the same shape, or one of them a number; complex ones are shown by their size.
    allowed : float
        Largest deviation, itself allowed.
    unit : str
    kind : {"relative", "absolute"}
        Deviations are divided by the reference, or not at all.
    scale : array_like, optional
        What relative deviations are divided by in place of the reference.
    """
    found, reference, size = np.broadcast_arrays(
        found, reference, np.abs(reference if scale is None else scale)
    )
    with np.errstate(divide="ignore", invalid="ignore"):
        off = np.abs(found - reference)
        off = np.where(found == reference, 0.0, off / size if kind == "relative" else off)
    # A value that is no number is the worst of all; argmax finds it first.
    worst = np.unravel_index(np.argmax(off), off.shape)
    value, wanted, deviation = (_plain(values[worst]) for values in (found, reference, off))
    assert deviation <= allowed, (
        f"{what}: found {value!r} {unit}, reference {wanted!r}; "
        f"{kind} deviation {deviation:.3g}, allowed {allowed:.3g}"
    )
    return {
        "what": what,
        "found": float(f"{value:.12g}"),
        "reference": float(f"{wanted:.12g}"),
        "deviation": float(f"{deviation:.3g}"),
        "allowed": float(allowed),
        "unit": unit,
        "kind": kind if scale is None else "scaled",
        "numbers": int(off.size),
    }


def _plain(number):
    return abs(complex(number)) if np.iscomplexobj(number) else float(number)


def worse(before, row):
    """Return the figure that is further off, for the numbers of both."""
    if before is None:
        return row
    worst = max(before, row, key=lambda one: one["deviation"] / one["allowed"])
    return worst | {"numbers": before["numbers"] + row["numbers"]}


def kept(before, figures, versions, date):
    """Return the content of the file with what this session found in place of what it says of them.

    `before` and what is returned: {file: {"date", "versions", "tests": {test: [figure, ...]}}}.
    """
    after = {name: dict(entry, tests=dict(entry["tests"])) for name, entry in before.items()}
    for (file, test), found in figures.items():
        entry = after.setdefault(file, {"tests": {}})
        entry |= {"date": date, "versions": versions}
        entry["tests"][test] = list(found.values())
    return {name: after[name] for name in sorted(after)}


def pytest_addoption(parser):
    parser.addoption("--figures", metavar="FILE", help="keep the figures of the validation in FILE")


@pytest.fixture
def figure(request):
    """Compare a figure with its reference, and record it; see `compared`."""
    own = {}
    request.node.user_properties.append((RECORDED, own))

    def compare(what, *arguments, **named):
        own[what] = worse(own.get(what), compared(what, *arguments, **named))

    return compare


class Recorder:
    """Keeps what tests report of their figures, from whichever process."""

    def __init__(self, path):
        self.path, self.figures = path, {}

    def pytest_runtest_logreport(self, report):
        file, _, test = report.nodeid.partition("::")
        for name, own in report.user_properties:
            if report.when == "call" and name == RECORDED:
                self.figures[Path(file).stem, test] = own

    def pytest_sessionfinish(self, exitstatus):
        if not self.figures:
            return
        if exitstatus:
            print(f"\n{self.path} is left as it was, because not all tests passed.")
            return
        before = json.loads(self.path.read_text(encoding="utf-8")) if self.path.exists() else {}
        versions = {"Python": platform.python_version()}
        versions |= {name: importlib.metadata.version(name) for name in LIBRARIES}
        date = datetime.datetime.now(datetime.UTC).date().isoformat()
        text = json.dumps(kept(before, self.figures, versions, date), indent=1, ensure_ascii=False)
        self.path.write_text(text + "\n", encoding="utf-8")


def pytest_configure(config):
    path = config.getoption("--figures", default=None)
    # Of several processes the one that the others report to.
    if path is not None and not hasattr(config, "workerinput"):
        config.pluginmanager.register(Recorder(Path(path)))
