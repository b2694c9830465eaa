"""The overlay in the report of a finished run of the same engine."""

import json
from dataclasses import dataclass
from pathlib import Path

from crankbase.errors import InputError
from crankbase.outputs import check_output, is_regular_file, recording_run_files
from crankbase.table import SI, Table
from crankfem.analyses.engine_mechanism import engine_inputs
from crankfem.analyses.provenance import used_files
from crankfem.analyses.run_results import AddedPart, RunResults
from crankfem.files.engine.engine_file import EngineFile
from crankfem.jobs.run_files import PICTURES, REPORT, RESULTS, the_only_run, write_results
from crankfem.report.interactive.plot import write_figure
from crankfem.report.interactive.style import diagram_figure
from crankfem.report.writing import write_report
from crankfem.satellites.measured.overlay import Overlay
from crankfem.satellites.measured.run import MeasuredVibration

FIGURE = "overlay"


@dataclass(frozen=True)
class FinishedRun:
    """The folder of a finished run, and the text of its results."""

    folder: Path
    content: bytes

    @classmethod
    def of(cls, folder: Path, engine: EngineFile) -> "FinishedRun":
        """Read a folder that `crankfem run` has filled.

        Raises
        ------
        InputError
            If it is none, the engine file is another or has changed since, or files of others are in the way.
        """
        path = folder / RESULTS
        if not is_regular_file(path):
            raise InputError(
                f"--report: given {folder}, which has no {RESULTS}; allowed is a folder that crankfem run "
                "has written."
            )
        content = path.read_bytes()
        try:
            read = {file.sha256 for file in RunResults.from_json(content).repeat.files}
        except (ValueError, LookupError, TypeError, AttributeError) as error:
            raise InputError(
                f"{path}: is not what crankfem run writes ({error}); run it again."
            ) from None
        if not {file.sha256 for file in used_files(engine_inputs(engine))} <= read:
            raise InputError(
                f"--report: given {folder}, of a run that has not read {engine.path} as it is now; allowed "
                "is one that has, because its report shows what is calculated of that."
            )
        with recording_run_files():
            check_output(folder / REPORT, "report")
            check_output(path, "results")
            check_output(folder / PICTURES / f"{FIGURE}.svg", "picture")
            check_output(folder / PICTURES / f"{FIGURE}.json", "plot")
        return cls(folder, content)

    def add(self, run: MeasuredVibration) -> Path:
        """Add measured orders over the calculated ones to results and report; return the report."""
        compared = run.overlay
        assert compared is not None
        pictures = self.folder / PICTURES
        with the_only_run(self.folder), recording_run_files():
            pictures.mkdir(exist_ok=True)
            compared.draw(pictures / f"{FIGURE}.svg")
            write_figure(
                pictures / f"{FIGURE}.json", *diagram_figure(compared.diagram(), compared.title)
            )
            record = json.loads(self.content)
            record["added"] = _part(run, compared).to_record()
            record["pictures"][FIGURE] = f"{FIGURE}.svg"
            record["interactive"][FIGURE] = f"{FIGURE}.json"
            stored = RunResults.from_json(write_results(self.folder, record).read_bytes())
            return write_report(stored, pictures, self.folder / REPORT)


def _part(run: MeasuredVibration, compared: Overlay) -> AddedPart:
    """Return what a report says and shows of measured orders over the calculated ones."""
    table, *notes = compared.parts()
    assert isinstance(table, Table)
    said = (f"Record {run.record}: {run.method}.", compared.conclusion, compared.doubt)
    return AddedPart(
        "Measured and calculated orders",
        tuple(SI.written(line) for line in (*said, *map(str, notes)) if line),
        FIGURE,
        compared.title,
        f"{compared.title}.",
        table.title,
        tuple(column.head() for column in table.columns),
        tuple(map(tuple, table.texts())),
    )
