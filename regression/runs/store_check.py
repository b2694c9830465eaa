"""Check of a result store: its file, each of its rows, and missing designs of its studies."""

import sqlite3
from collections.abc import Mapping
from contextlib import closing
from dataclasses import dataclass, field
from pathlib import Path

from regression.plans.plan import MODEL_VERSION, StudyPlan
from regression.records import content_key
from regression.runs.store import ResultStore
from regression.runs.store_file import (
    SCHEMA_VERSION,
    check_place,
    connect_readonly,
    is_ours,
    missing_parts,
    schema_version,
)
from regression.runs.study import is_list_sound, registered_designs


@dataclass(frozen=True)
class StudyCheck:
    """One study of a store, by its key, with the damage of its plan or list of designs ("" if none).

    `designs` counts its designs, `missing` those without a result; None if the plan is damaged, or of
    another version of the finite element model.
    """

    study: str
    damaged: str
    designs: int | None = None
    missing: int | None = None


@dataclass(frozen=True)
class StoreCheck:
    """Result of a check of a store.

    Attributes
    ----------
    file : str
        Why the file is unreliable; empty if SQLite finds it sound.
    status : dict
        "done", "failed" and "lost" to the number of sound rows.
    damaged : dict
        Design, or position of an imported row, to the fault of its row.
    """

    path: Path
    file: str = ""
    status: Mapping[str, int] = field(default_factory=dict)
    damaged: Mapping[str, str] = field(default_factory=dict)
    studies: tuple[StudyCheck, ...] = ()

    @property
    def sound(self) -> bool:
        """Whether nothing is damaged."""
        return not (self.file or self.damaged or any(study.damaged for study in self.studies))

    @property
    def missing(self) -> int:
        """Designs without a result, of all studies of this version of the model."""
        return sum(study.missing or 0 for study in self.studies)


def check_store(path: str | Path) -> StoreCheck:
    """Check a result store: SQLite's integrity check, every row's checksum, every study's plan.

    Raises
    ------
    InputError
        If there is no such file, or it is no result store, or of another layout.
    StudyStoppedError
        If it cannot be opened now.
    """
    file = Path(path)
    check_place(file, readonly=True)
    why = _file_damage(file)
    if why and is_ours(file):
        return StoreCheck(file, why)
    with ResultStore(file, readonly=True) as store:
        status = {"done": 0, "failed": 0, "lost": 0}
        for outcome in store.every_outcome():
            status[outcome.status] += 1
        studies = tuple(_check_study(store, *known) for known in store.studies().items())
        store.extra_rows()
        return StoreCheck(file, why, status, dict(store.damaged), studies)


def _file_damage(path: Path) -> str:
    """State why SQLite finds a file unreliable; empty if it is sound, or not readable for another reason."""
    try:
        with closing(connect_readonly(path)) as connection:
            found = [text for (text,) in connection.execute("PRAGMA integrity_check")]
            lacking = (
                missing_parts(connection) if schema_version(connection) == SCHEMA_VERSION else []
            )
    except UnicodeDecodeError:  # what SQLite says of it quotes damaged text
        return "the names of its tables cannot be read"
    except sqlite3.DatabaseError as error:
        return "" if isinstance(error, sqlite3.OperationalError) else str(error)
    if found != ["ok"]:
        first = " ".join(found[0].replace("*** in database main ***", "").split())
        return first + ("; and others" if len(found) > 1 else "")
    return f"it has no {lacking[0]}" if lacking else ""


def _check_study(store: ResultStore, key: str, record: Mapping[str, object] | None) -> StudyCheck:
    if record is None or content_key(record) != key:
        return StudyCheck(key, "its plan")
    if record.get("model_version") != MODEL_VERSION:
        return StudyCheck(key, "")
    plan = StudyPlan.from_record(record)
    keys = {design.key for design in registered_designs(store, plan).designs}
    found = store.outcomes(keys)
    finished = sum(not outcome.lost for outcome in found.values())
    damaged = "" if is_list_sound(store, plan) else "its list of designs"
    return StudyCheck(key, damaged, len(keys), len(keys) - finished)
