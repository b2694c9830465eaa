"""What the core's tests of every command and file do with the class document."""

import json
from pathlib import Path

from crankfem.satellites.class_document.document import check_submission, class_document

# Of a command that reads files: a line of it. Its JSON, which holds paths, is looked at here.
READS = {"class": ("class", "PATH", "--output", "submission")}
# Of a snapshot the lines whose printed text it keeps, and the pages that they write.
SNAPSHOTS = {"class": ("class 5rt-flex50d --output submission",)}
PAGES = {"class": "submission/class.html"}


def document(file: Path):
    """Sentences and tables of the document."""
    from file_doors import Answer, named_by, vibration_of

    run = vibration_of(file)
    check_submission(run.engine_file)
    parts = class_document(run)
    # By columns: values of one quantity are the same but for round-off of the largest of them.
    content = [
        [part.sentences, [[*map(list, zip(*item.table.rows, strict=True))] for item in part.tables]]
        for part in parts
    ]
    return Answer(json.loads(json.dumps(content, default=str)), named_by(file, "class"))


def torsional_modes(file: Path):
    """Natural frequencies, on which the document stands."""
    from file_doors import modes, torsional

    return torsional(modes)(file)


# Of what commands calculate of engines: what makes parts of the answer of a file, then all of it.
DOORS = {"class": (torsional_modes, document)}
