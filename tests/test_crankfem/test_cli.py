import json
import math
import re
import shlex
import sys
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
import typer.main

import crankfem as cf
from comparing import close
from crankbase.errors import InputError, MissingLibraryError, SolveError
from crankfem.cli import app as cli
from crankfem.cli.arguments import parse_gamma
from crankfem.cli.commands import completion
from crankfem.cli.console import RunProgress
from crankfem.files.engine.file_kinds import SECTIONS
from crankfem.files.engine.throw_file import load_throw
from crankfem.files.reading.data_files import shipped_names
from crankfem.jobs.exit_codes import MEANINGS
from dynamics import wording
from fem.superelement import shaft_unknowns, solve_shaft
from fem.symmetry import pin_surfaces
from stand_ins import stored_results, typed

ENTRY = [sys.executable, "-c", "from crankfem.cli.entry import main; main()"]
COMMANDS = sorted(typer.main.get_command(cli.app).commands)


@pytest.mark.parametrize("command", COMMANDS)
def test_help_has_an_example(call, command):
    answer = call(command, "--help")
    assert answer.code == 0
    assert f"Example: crankfem {command} " in " ".join(answer.out.split())


def test_every_command_can_be_quiet_and_those_that_answer_have_json():
    for name, command in typer.main.get_command(cli.app).commands.items():
        options = {option for parameter in command.params for option in parameter.opts}
        assert {"--quiet", "-q"} <= options, name
        assert "--json" in options or name in ("new", "report")


def test_without_a_command_there_is_help_and_code_2(call):
    answer = call()
    assert (answer.code, answer.err) == (2, "")
    shown = " ".join(answer.out.split())
    for group in ("Main job", "Throw", "Compliance", "Forces", "Vibration", "Files"):
        assert f"─ {group} ─" in shown
    for code in MEANINGS:
        assert f" {code} " in shown.partition("Exit codes:")[2]


def test_version(call):
    answer = call("--version")
    assert (answer.code, answer.err) == (0, "")
    assert re.fullmatch(r"crankfem \S.*\n", answer.out)


# -------------------------------------------------------------------------------- ends and streams


@pytest.mark.parametrize(
    ("error", "code", "sentence"),
    [
        (InputError("field: wrong."), 2, "field: wrong."),
        (FileNotFoundError(2, "No such file", "a.csv"), 2, "a.csv: No such file."),
        (OSError(28, "No space left on device", "a.csv"), 3, "a.csv: No space left on device."),
        (MissingLibraryError("no gmsh."), 3, "no gmsh."),
        (MemoryError(), 3, "The machine does not have enough memory for this."),
        (ImportError("No module named 'x'"), 3, "No module named 'x'."),
        (
            ZeroDivisionError("division by zero"),
            3,
            "ZeroDivisionError: division by zero, an unexpected error; set CRANKFEM_TRACEBACK=1 to see "
            "where it comes from.",
        ),
        (BrokenPipeError(), 141, None),
    ],
)
def test_every_error_is_a_sentence_and_a_code(call, monkeypatch, error, code, sentence):
    def fail(_):
        raise error

    monkeypatch.setattr("crankfem.files.engine.field_tables.section_tables", fail)
    answer = call("fields")
    assert (answer.code, answer.out) == (code, "")
    assert answer.err == ("" if sentence is None else f"Error: {sentence}\n")


def test_a_traceback_is_shown_on_demand(call, monkeypatch):
    monkeypatch.setenv("CRANKFEM_TRACEBACK", "1")
    answer = call("fields", "nothing")
    assert answer.code == 2
    assert "Traceback" in answer.err
    assert answer.err.splitlines()[-1].startswith("Error: section: given 'nothing'")


@pytest.mark.slow
def test_an_output_that_nobody_reads_ends_quietly(spawn):
    piped = ["bash", "-c", f"{shlex.join(ENTRY)} fields | head -1; echo ${{PIPESTATUS[0]}}"]
    answer = spawn(command=piped)
    assert answer.out.splitlines()[0].startswith("[engine]")
    assert answer.out.splitlines()[-1] == "141"
    assert answer.err == ""


ENDS = {
    "acceptable": (0, ""),
    "not acceptable": (4, "The verdict.\n"),
    "undecided": (5, f"{wording.VERDICTS['undecided']}: give this.\n"),
}


@pytest.mark.slow
@pytest.mark.parametrize("status", ENDS)
@pytest.mark.parametrize("option", ["--json", "--quiet", "--full"])
def test_strict_ends_by_the_verdict(call, monkeypatch, status, option):
    code, sentence = ENDS[status]
    results = stored_results()
    decision = {"status": status, "sentence": "give this", "trials": []}
    results["vibration"]["assessment"] |= {"sentence": "The verdict.", "decision": decision}
    run = typed(results).vibration
    monkeypatch.setattr("crankfem.analyses.vibration.run.engine_vibration", lambda *_, **__: run)
    answer = call("vibration", "6chn25-34", "--strict", option)
    assert answer.code == code
    assert sentence in answer.err
    assert ("Note: not used of 6chn25-34: " in answer.err) == (option == "--full")
    if option == "--json":
        reasons = {"reasons": ["give this"]}
        assert answer.json()["assessment"]["decision"] == decision | reasons
    # Without the option the verdict does not matter.
    assert call("vibration", "6chn25-34", option).code == 0


@pytest.mark.parametrize("command", ["run", "vibration"])
def test_strict_refuses_at_once_what_cannot_be_judged(
    call, monkeypatch, tmp_path, edit, six_cylinders, command
):
    def computed(*_, **__):
        raise AssertionError("nothing is computed for it")

    monkeypatch.setattr("crankfem.jobs.pipeline.run_engine", computed)
    monkeypatch.setattr("crankfem.analyses.vibration.run.engine_vibration", computed)
    (tmp_path / "mine.toml").write_text(edit(six_cylinders, {"[gas]": None}), encoding="utf-8")
    answer = call(command, "mine.toml", "--strict")
    assert (answer.code, answer.out) == (2, "")
    assert answer.err.lstrip().startswith("Error: --strict: ")
    assert sorted(path.name for path in tmp_path.iterdir()) == ["mine.toml"]


def test_quiet_leaves_only_results(call, monkeypatch):
    plain = call("formulas", "6chn25-34", "--no-fe", "--gamma", "120")
    quiet = call("formulas", "6chn25-34", "--no-fe", "--gamma", "120", "-q")
    assert (quiet.err, quiet.out) == ("", plain.out)
    assert call("formulas", "6chn25-34", "--no-fe", "--gamma", "120 deg").out == plain.out
    # Errors are told all the same.
    assert call("fields", "nothing", "-q").err.startswith("Error: section")


def test_quiet_progress_prints_nothing(capsys):
    with RunProgress(quiet=True) as progress:
        progress.step("Working")
        progress.design(0, 2, None)
        progress.note("a remark")
        progress.finish()
    captured = capsys.readouterr()
    assert captured.out + captured.err == ""


@pytest.mark.parametrize("given", ["2 rad", "114.591559026 deg", "0.318309886 turn"])
def test_gamma_takes_any_angle(given):
    # Nine digits were given.
    assert parse_gamma(given, quiet=True) == close(math.degrees(2.0), rel=1e-8)


# -------------------------------------------------------------------------------------- completion


def test_names_and_files_are_completed(tmp_path, model_file):
    (tmp_path / "6mine.toml").touch()
    (tmp_path / "notes.md").touch()
    (tmp_path / "6folder").mkdir()
    (tmp_path / "6folder" / "a.toml").touch()
    assert completion.engines("6") == [
        *(name for name in shipped_names("engine") if name.startswith("6")),
        "6folder/",
        "6mine.toml",
    ]
    assert completion.engines("6folder/") == ["6folder/a.toml"]
    assert completion.engines("nowhere/") == []
    assert "mwm-six" in completion.engines_and_chains("m")
    assert completion.sections("tors") == ["torsional_damper"]
    assert set(completion.sections("")) == {*SECTIONS, "chain"}
    context = SimpleNamespace(params={"model": model_file})
    assert completion.dimensions(context, "web_w") == ["web_width="]
    assert completion.dimensions(context, "web_width=3") == []
    assert completion.dimensions(SimpleNamespace(params={}), "w") == []


def test_completion_and_help_load_nothing_slow(spawn):
    code = (
        "import sys; from crankfem.cli.app import LoadedOnDemand; dict(LoadedOnDemand()); "
        "from crankfem.cli.commands import completion; "
        "completion.any_input(''); completion.shipped(''); "
        "print([name for name in ('numpy', 'scipy', 'pydantic', 'pint', 'gmsh', 'matplotlib') "
        "if name in sys.modules])"
    )
    answer = spawn(command=[sys.executable, "-c", code])
    assert answer.out.strip() == "[]", answer.err


@pytest.mark.further
def test_a_throw_is_analyzed_without_libraries_that_it_does_not_need(spawn):
    code = (
        "import sys; from crankfem.cli.entry import main; main(); "
        "print([name for name in ('skfem', 'scipy.linalg', 'matplotlib') if name in sys.modules])"
    )
    command = [sys.executable, "-c", code, "throw"]
    answer = spawn("6chn25-34", "--accuracy", "0.1", command=command)
    assert answer.out.splitlines()[-1] == "[]", answer.err


@pytest.mark.slow
def test_a_shell_is_answered(spawn, spawn_environment):
    words = {"COMP_WORDS": "crankfem throw 6chn25", "COMP_CWORD": "2"}
    answer = spawn(env=spawn_environment(_CRANKFEM_COMPLETE="complete_bash", **words))
    assert answer.out.split() == ["6chn25-34"], answer.err


# ------------------------------------------------------------------------------- packages of extras


@pytest.mark.parametrize(
    ("package", "arguments", "extra"),
    [
        ("distributed", ("doe", "6chn25-34", "--dask", "tcp://127.0.0.1:9"), "cluster"),
        ("pyarrow", ("results", "runs.sqlite", "runs.parquet"), "tables"),
    ],
)
def test_a_missing_package_is_named_with_its_extra(call, monkeypatch, package, arguments, extra):
    for name in [name for name in sys.modules if name.partition(".")[0] == package]:
        monkeypatch.setitem(sys.modules, name, None)
    monkeypatch.setitem(sys.modules, package, None)
    answer = call(*arguments)
    assert (answer.code, answer.out) == (3, "")
    assert f"pip install 'crankfem[{extra}]'" in answer.err
    assert answer.err.count("Error: ") == 1


# ------------------------------------------------------------------------------------- new, check


def test_new_overwrites_nothing(call, tmp_path):
    (tmp_path / "mine.toml").write_text("precious", encoding="utf-8")
    answer = call("new", "mine.toml")
    assert answer.code == 2
    assert (tmp_path / "mine.toml").read_text(encoding="utf-8") == "precious"


def test_fields_are_explained(call):
    answer = call("fields", "throw")
    assert (answer.code, answer.err) == (0, "")
    for word in ("[throw] (required)", "[[throw.further_pins]]", "web_tip_thickness", "D_shm"):
        assert word in answer.out
    assert "[rod]" not in answer.out
    tables = call("fields", "--json").json()["sections"]
    allowed = [row["allowed"] for table in tables for row in table["rows"]]
    assert not any(text.endswith(("default ", "default ()")) for text in allowed)
    titles = [table["title"] for table in tables]
    assert {"[engine]", "[throw.counterweight]", "[rod]"} <= set(titles)


@pytest.mark.slow
def test_export_of_solid_mesh_and_shaft(call, tmp_path):
    for file, options in (("a.step", ()), ("shaft.stp", ("--shaft",)), ("m.vtu", ("--size", "2"))):
        answer = call("export", "6chn25-34", file, "--quiet", *options)
        assert (answer.code, answer.err) == (0, "")
        assert f"{file} written" in answer.out
        assert (tmp_path / file).stat().st_size > 10_000
    record = call("export", "6chn25-34", "m.msh", "--part", "auto", "--size", "2", "--json").json()
    assert record["file"] == "m.msh"
    assert record["surfaces"]["middle plane"] > 0


@pytest.mark.further
def test_a_throw_from_cad_has_the_compliance_of_its_dimensions(call):
    assert call("export", "6chn25-34", "part.step").code == 0
    cad = call("throw", "part.step", "--accuracy", "0.02", "--json")
    assert (cad.code, cad.err) == (0, "")
    own = call("throw", "6chn25-34", "--accuracy", "0.02", "--json").json()
    found = cad.json()
    assert found["model"].startswith("quarter")
    assert found["dimensions"]["pins"][0]["diameter"] == close(0.180)
    error = found["error_estimate"] + own["error_estimate"]
    for support in ("pinned", "guided"):
        expected = own["supports"][support]
        for name in ("axial_compliance", "torsional_compliance", "influence_coefficient"):
            assert found["supports"][support][name] == close(expected[name], rel=error)
    assert found["mass"] == close(own["mass"], rel=1e-6)


# ------------------------------------------------------------------------------- throw, formulas


@pytest.mark.slow
def test_throw_as_json(call):
    content = call("throw", "6chn25-34", "--accuracy", "0.1", "--json").json()
    pinned, guided = content["supports"]["pinned"], content["supports"]["guided"]
    assert 0.0 < guided["axial_compliance"] < pinned["axial_compliance"]
    assert pinned["axial_compliance"] == close(1.27e-9, rel=0.05)
    assert content["error_estimate"] < 0.1
    assert np.shape(content["stiffness"]) == (12, 12)
    for support in (pinned, guided):
        left, right = support["reactions"]["left"], support["reactions"]["right"]
        total = np.array(left["force"]) + np.array(right["force"])
        assert total == close([0.0, content["radial_force"], 0.0], abs=1.0)


@pytest.mark.slow
def test_a_pin_force_of_three_components(call):
    arguments = ("--accuracy", "0.1", "--pin-force", "4, -10, 1 kN")
    record = call("throw", "yamz-5340", *arguments, "--json").json()
    assert record["pin_force"] == [4e3, -1e4, 1e3]
    for own in record["supports"].values():
        total = sum(np.array(own["reactions"][side]["force"]) for side in ("left", "right"))
        assert total == close([-4e3, 1e4, -1e3], abs=1e-3)
        assert own["axial_force"] == close(-own["reactions"]["right"]["force"][2])


@pytest.mark.further
def test_forces_on_both_halves_of_a_split_pin(call):
    """The ends balance both at once, about each axis, and what they do is the sum of two loads."""
    second = ("--pin-force", "8 kN")  # towards the shaft from the second half, 30 deg on
    command = ("throw", "buick-3800", "--accuracy", "0.1", "--json", "--pictures", "p")
    both = call(*command, "--pin-force", "1, -20, 3 kN", *second).json()
    throw, material = load_throw("buick-3800")
    analysis = cf.analyze_throw(throw, material, 0.1)
    places = np.array([pin.center for pin in pin_surfaces(analysis.mesh)])  # where forces act
    forces = np.array([both["pin_force"], *both["further_pin_forces"]])
    assert forces[1] == close([4e3, -8e3 * np.cos(np.pi / 6.0), 0.0], abs=1e-6)
    for name, own in both["supports"].items():
        left, right = (own["reactions"][side] for side in ("left", "right"))
        force = np.sum(forces, axis=0) + left["force"] + right["force"]
        assert force == close(np.zeros(3), abs=0.02)
        moment = np.sum(np.cross(places, forces), axis=0) + left["moment"] + right["moment"]
        moment += np.cross([0.0, 0.0, throw.length], right["force"])
        assert moment == close(np.zeros(3), abs=2e-3)
        assert own["axial_force"] == close(-right["force"][2])
        total = sum(
            analysis.reactions(force, name, pin).left.force for pin, force in enumerate(forces)
        )
        assert left["force"] == close(total, abs=1e-3)
    assert [Path(picture).name for picture in both["pictures"]] == ["throw_reactions.svg"]
    assert call(*command, *second, *second, *second).err.lstrip().startswith("Error: --pin-force: ")


# -------------------------------------------------------------------------------- fit, doe, report


def test_an_interrupt_ends_with_a_word_and_130(call, monkeypatch):
    def interrupted(*_, **__):
        raise KeyboardInterrupt

    monkeypatch.setattr("crankfem.analyses.study.studies.run_plan", interrupted)
    answer = call("doe", "6chn25-34")
    assert answer.code == 130
    assert answer.out == ""
    assert "Traceback" not in answer.err


@pytest.mark.parametrize(
    ("finished", "sentence"),
    [
        # Without a study, or before anything is known of it, nothing is kept.
        (None, "Stopped.\n"),
        (2, "Stopped. 2 of 9 designs are finished and kept; the same command reuses them.\n"),
    ],
)
def test_an_interrupted_run_says_what_is_kept(call, monkeypatch, finished, sentence):
    def interrupted(*_, progress, **__):
        progress.step("Running the study")
        if finished is not None:
            progress.design(finished, 9, None)
        raise KeyboardInterrupt

    monkeypatch.setattr("crankfem.jobs.pipeline.run_engine", interrupted)
    answer = call("run", "6chn25-34", "--quiet")
    assert (answer.code, answer.out, answer.err) == (130, "", sentence)


def test_results_without_numbers_never_become_json(capsys):
    from crankfem.cli.console import print_json

    with pytest.raises(SolveError, match="result value is nan"):
        print_json({"value": float("nan")})
    print_json({"mass": 1.5})
    assert json.loads(capsys.readouterr().out) == {"mass": 1.5}


@pytest.mark.slow
def test_export_of_a_deck_for_calculix(call, tmp_path):
    deck = tmp_path / "deck.inp"
    assert call("export", "6chn25-34", deck, "--size", "3", "--calculix").code == 0
    assert "*RIGID BODY" in deck.read_text(encoding="utf-8").upper()


def test_the_page_tells_all_commands_and_exit_codes():
    page = (Path(__file__).parents[2] / "docs" / "command-line.md").read_text(encoding="utf-8")
    table = page.partition("| for | commands |")[2].partition("\n\n")[0]
    assert sorted(re.findall(r"`([a-z][\w-]*)`", table)) == COMMANDS
    for code, meaning in MEANINGS.items():
        assert f"| {code} | {meaning} |" in page


@pytest.mark.parametrize(
    "arguments",
    [
        ("check", "9" * 5000),
        ("9" * 5000,),
        ("check", "6chn25-34", "--" + "9" * 5000),
        ("new", "x.toml", "--cylinders", "9" * 5000),
        ("harmonics", "6chn25-34", "--speed", "1 m**9**9**9"),
        ("harmonics", "6chn25-34", "--speed", "5 mm^60/km^60/s"),
        ("harmonics", "6chn25-34", "--units", "in**9**9**9"),
        ("formulas", "6chn25-34", "--gamma", "9" * 5000),
    ],
    ids=lambda arguments: " ".join(arguments)[:40],
)
def test_what_is_endless_is_refused_in_a_short_sentence(call, arguments):
    answer = call(*arguments)
    assert answer.code == 2
    assert answer.err.startswith("Error: ")
    assert len(answer.err) < 600


def test_fields_of_chain_files(call):
    content = call("fields", "chain", "--json").json()
    titles = [table["title"] for table in content["sections"]]
    assert titles.count("[chain]") == 2
    assert "[[chain.nodes]]" in titles
    torsional, axial = (table for table in content["sections"] if table["title"] == "[chain]")
    units = [
        {row["name"]: row["unit"] for row in table["rows"]}["stiffness"]
        for table in (torsional, axial)
    ]
    assert units == ["N m/rad", "N/m"]
    assert 'kind = "axial"' in call("fields", "chain").out


@pytest.mark.slow
def test_throw_between_neighbors_under_a_pin_force(call):
    arguments = ("--accuracy", "0.1", "--gamma", "90 deg", "--pin-force", "30 kN")
    record = call("throw", "6chn25-34", *arguments, "--json").json()
    assert list(record["supports"]) == ["pinned", "guided", "neighbors 90 deg"]
    engine = cf.load_engine("6chn25-34")
    throw = cf.analyze_throw(engine.throw, engine.material, accuracy=0.1).superelement.joined
    # 41 throws of a helix, assembled: all pulled, and all loaded by the radial force.
    turned = [throw.turned(angle_deg=90.0 * place) for place in range(41)]
    loads = np.zeros((18 * 42, 2))
    loads[6 * 41 + 2, 0] = 1.0
    for place, own in enumerate(turned):
        loads[shaft_unknowns(place, 41, 12), 1] += 3e4 * own.radial_loads[:, 0]
    motions = solve_shaft(turned, loads)
    pulled, opened = motions[6 * 21 + 2] - motions[6 * 20 + 2]
    found = record["supports"]["neighbors 90 deg"]
    assert found["axial_compliance"] == close(pulled, rel=1e-8)
    assert found["influence_coefficient"] == close(opened / 3e4, rel=1e-8)
    assert found["axial_force"] == close(opened / pulled, rel=1e-8)
    for own in record["supports"].values():
        assert own["axial_force"] == close(-own["reactions"]["right"]["force"][2])
        assert own["axial_force"] == close(3e4 * own["axial_force_per_radial"])
