"""What the campaigns about studies share: a study of ten factors, and its store."""

import os
import sqlite3
from collections.abc import Iterable
from pathlib import Path

from geometry.throw import CrankThrow
from regression.plans.designs import DesignChoice
from regression.plans.factors import Factor
from regression.plans.plan import StudyPlan, plan_designs

ROOT = Path(__file__).resolve().parents[2]
THROW = CrankThrow(
    crank_radius=0.170,
    main_journal_diameter=0.220,
    pin_diameter=0.180,
    main_journal_length=0.120,
    pin_length=0.139,
    web_width=0.285,
    web_thickness=0.068,
    fillet_radius=0.012,
    main_journal_bore=0.040,
    pin_bore=0.060,
)
# Ten dimensions of an ordinary throw, each over a good part of what engines have.
RANGES = {
    "crank_radius": (0.160, 0.180),
    "main_journal_diameter": (0.210, 0.230),
    "pin_diameter": (0.175, 0.190),
    "main_journal_length": (0.100, 0.140),
    "pin_length": (0.120, 0.158),
    "web_width": (0.275, 0.330),
    "web_thickness": (0.060, 0.098),
    "fillet_radius": (0.008, 0.014),
    "main_journal_bore": (0.030, 0.060),
    "pin_bore": (0.040, 0.070),
}


def study(
    designs: int, accuracy: float, names: Iterable[str] = RANGES, throw: CrankThrow = THROW
) -> StudyPlan:
    """Factors, by default ten, in a Latin hypercube, a tenth of the designs held out."""
    held_out = max(1, designs // 10)
    factors = tuple(Factor(name, "m", *RANGES[name]) for name in names)
    choice = DesignChoice("latin hypercube", runs=designs - held_out)
    return StudyPlan(throw, factors, choice, held_out=held_out, accuracy=accuracy)


def study_file(
    path: Path,
    designs: int,
    accuracy: float,
    names: Iterable[str] = RANGES,
    throw: CrankThrow = THROW,
) -> Path:
    """Write the same study as a file for the command line."""
    fields = throw.model_dump(mode="json", exclude_defaults=True)
    held_out = max(1, designs // 10)
    lines = ["[throw]", *(f'{name} = "{1e3 * value:g} mm"' for name, value in fields.items())]
    lines += [
        "",
        "[study]",
        'design = "latin hypercube"',
        f"runs = {designs - held_out}",
        f"held_out = {held_out}",
        f"accuracy = {accuracy}",
        "",
        "[study.factors]",
    ]
    for name in names:
        low, high = RANGES[name]
        lines.append(f'{name} = {{ from = "{1e3 * low:g} mm", to = "{1e3 * high:g} mm" }}')
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    return path


def environment() -> dict[str, str]:
    """Environment in which a new Python finds the packages of this checkout."""
    paths = [str(ROOT), *filter(None, [os.environ.get("PYTHONPATH")])]
    return os.environ | {"PYTHONPATH": os.pathsep.join(paths)}


def rows(store: Path) -> list[tuple[object, ...]]:
    """Finished designs as any program reads them, in the order in which they came."""
    if not store.is_file():
        return []
    connection = sqlite3.connect(store, timeout=30.0)
    try:
        return connection.execute(
            "SELECT key, status, finished_at, seconds, responses, reason, attempts "
            "FROM designs ORDER BY rowid"
        ).fetchall()
    except sqlite3.OperationalError:  # the tables are not made yet
        return []
    finally:
        connection.close()


def total(plan: StudyPlan) -> int:
    """Count the different designs of a study."""
    return len({design.key for design in plan_designs(plan).designs})


def said(what: str, *, good: bool) -> bool:
    """Print one finding."""
    print(f"{'ok  ' if good else 'BAD '} {what}", flush=True)
    return good
