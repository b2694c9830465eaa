"""What a person wrote stays as it is, and every value in a sentence of a run can be written otherwise."""

import json

import pytest

from crankbase.errors import InputError
from crankbase.sentences import END, START, Sentence
from crankbase.table import Table, parse_output_units
from crankfem.analyses.findings import (
    finding_parts,
    main_findings,
    verdict_line,
    vibration_findings,
)
from crankfem.analyses.mechanism.mechanism_results import mechanism_details
from crankfem.analyses.mechanism.mechanism_run import run_mechanism
from crankfem.analyses.throw.stress import stress_results
from crankfem.analyses.throw.throw_record import throw_results
from crankfem.analyses.vibration.assessment import Assessment
from crankfem.analyses.vibration.run import EngineVibration, engine_vibration
from crankfem.analyses.vibration.tables import assessment_parts, vibration_parts
from crankfem.files.engine.engine_file import load_engine, load_mechanism
from crankfem.report.summary import worst_tables
from crankfem.report.text_filters import printed
from plain_values import texts_with_plain_values
from stand_ins import stored_results, stressed, typed

IMPERIAL = parse_output_units("imperial")
SERIES = "tests of the 500 mm bore series, 12.3456 MPa"
DOI = "Vestnik AGTU, doi 10.24143/2073-1574-2021-4-75-83; table 2"


def with_source(source):
    """A run whose one limit is assumed, by this source, and by nothing that decides."""
    results = stored_results()
    assessment = results["vibration"]["assessment"]
    assessment["decision"] |= {"status": "not acceptable", "sentence": ""}
    limits = [
        limit | {"source": source, "assumed": True, "judged_to_rpm": 575.0}
        for limit in assessment["limits"][:1]
    ]
    assessment |= {"limits": limits, "running_rpm": [200.0, 515.0]}
    return results


def test_other_units_leave_a_cited_source_as_it_is():
    record = with_source(SERIES)["vibration"]["assessment"]
    lines = [*assessment_parts(Assessment.from_record(record), IMPERIAL)]
    assert any(f": {SERIES}, assumed; judged from 200 to 575 1/min" in str(line) for line in lines)


@pytest.mark.parametrize("source", [DOI, SERIES])
def test_the_first_screen_neither_shortens_nor_cuts_a_source(source):
    results = with_source(source)
    # Two statements of more weight leave room for the one about what is assumed.
    stated = [printed(text) for _, text in main_findings(typed(results).findings)]
    assert any(f"is assumed ({source}): give the maker's." in text for text in stated)


def refuse(name):
    def refused(self, *_, **__):
        raise AssertionError(f"{self!r} loses its values by {name}")

    return refused


@pytest.mark.slow
@pytest.mark.parametrize("engine", ["vw-tdi", "6chn25-34", "7l32-40-set"])
def test_every_value_of_a_run_stays_a_value(engine, monkeypatch):
    for name in ("__format__", "upper", "capitalize", "replace", "partition", "split", "strip"):
        monkeypatch.setattr(Sentence, name, refuse(name))
    file = load_engine(engine)
    run = engine_vibration(file, coupled=True)
    findings = vibration_findings(run, file)
    read = EngineVibration.from_record(json.loads(json.dumps(run.to_record())))
    for results in (run, read, *findings):
        assert [*texts_with_plain_values(results)] == []
    shown = [*vibration_parts(run, IMPERIAL), *worst_tables(run, IMPERIAL), verdict_line(run)]
    for part in (*shown, *finding_parts(findings, IMPERIAL)):
        texts = [part]
        if isinstance(part, Table):
            texts = [part.title, part.note, *(cell for row in part.texts(IMPERIAL) for cell in row)]
        assert not any(START in str(text) for text in texts)


@pytest.mark.slow
@pytest.mark.parametrize("engine", ["5rt-flex50d", "8chn26-26", "yamz-5340", "7l32-40-set"])
def test_every_value_of_a_mechanism_stays_a_value(engine):
    details = mechanism_details(run_mechanism(load_mechanism(engine)))
    assert [*texts_with_plain_values(details)] == []


@pytest.mark.slow
def test_every_value_of_a_throw_stays_a_value(coarse_throw):
    engine, analysis = coarse_throw("6chn25-34")
    stresses = stressed(engine.throw, engine.material, 0.2)
    for results in (throw_results(analysis, 1e5), stress_results(stresses)):
        assert [*texts_with_plain_values(results)] == []


def test_a_text_with_the_marks_of_values_is_refused(tmp_path):
    path = tmp_path / "engine.toml"
    path.write_text(f'[engine]\nname = "{START}6|x{END}"\n', encoding="utf-8")
    with pytest.raises(InputError, match=r"engine\.name: .* U\+E000"):
        load_engine(path)
