"""The results of a run that tests change and show again."""

import json
from pathlib import Path

from crankfem.analyses.run_results import RunResults

STORED = Path(__file__).parent / "test_crankfem" / "report_results.json"


def stored_results():
    """Return the content of results.json."""
    return json.loads(STORED.read_text(encoding="utf-8"))


def typed(content):
    """Return the results that results.json holds."""
    return RunResults.from_json(json.dumps(content))
