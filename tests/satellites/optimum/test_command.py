"""The command `optimum`, in a model, and its limits on frequencies."""

import json
from pathlib import Path

import numpy as np
import pytest
import typer

from comparing import close
from crankbase.errors import InputError
from crankfem.analyses.shaft.chains import engine_torsional_chain
from crankfem.files.engine.engine_file import load_engine
from crankfem.files.engine.used_values import command_use, not_used_of
from crankfem.files.reading.data_files import input_path
from crankfem.satellites.optimum import searches
from crankfem.satellites.optimum.command import optimum
from crankfem.satellites.optimum.frequencies import EngineFrequencies, frequency_limit
from dynamics.chains.engine_chains import axial_chain
from fitted_models import made_model
from regression import optimum as optimum_module
from regression.models.compliance_model import ComplianceModel
from stand_ins import caller_of

ENGINE = "6chn25-34"


@pytest.fixture
def path(tmp_path):
    made_model().save(tmp_path / "m.json")
    return tmp_path / "m.json"


@pytest.fixture
def run():
    app = typer.Typer()
    app.command()(optimum)
    return caller_of(app)


@pytest.mark.slow
def test_thinnest_web(run, path):
    arguments = (path, "--minimize", "web_thickness")
    limit = ("--limit", "axial_compliance <= 1.2e-9 m/N")
    found = json.loads(run(*arguments, *limit, "--json"))
    needed = 0.068 * 1.3 / 1.2 * 1.01 / 0.995 * (0.3 / 0.33) ** 0.5
    assert found["value"] == close(needed, rel=1e-6)
    assert found["factors"]["web_width"] == 0.330
    assert found["limits"][0]["worst"] == close(1.2e-9, rel=1e-6)
    assert found["throw"]["web_thickness"] == found["value"]
    held = json.loads(run(*arguments, *limit, "--fixed", "web_width=300mm", "--json"))
    assert held["value"] == close(needed * (0.33 / 0.3) ** 0.5, rel=1e-6)
    plain = json.loads(run(*arguments, *limit, "--no-margin", "--json"))
    assert plain["value"] == close(needed * 0.995 / 1.01, rel=1e-6)
    out = run(*arguments, *limit, "--limit", "mass <= 200 kg")
    assert f"Smallest web_thickness: {1e3 * needed:.4g} mm" in out
    assert "web_width = 330 mm (end of its range)" in out
    assert "just" in out
    assert "with room" in out
    assert "The limits are kept at the worst end of the model's error band." in out


ENDS = ("lower", "upper")


@pytest.fixture
def frequencies():
    """An engine whose throws are 0.5 and 0.8 times as soft in the shaft as pinned."""
    engine = load_engine(input_path(ENGINE))
    shares = np.array([0.8, 0.5, 0.5, 0.5, 0.5, 0.8])
    return EngineFrequencies(
        engine, shares, shares, throw_mass=110.0, throw_inertias=8.0 * np.ones(len(shares))
    )


@pytest.fixture
def short_search(monkeypatch):
    """Few generations, for chains are slow to ask; the end of the search is as exact as ever."""
    monkeypatch.setattr(optimum_module, "_GENERATIONS", 12)


def test_frequencies_fall_as_throws_soften(frequencies):
    first = [frequencies.axial(e) for e in (0.8e-9, 1.0e-9, 1.2e-9)]
    assert first[0] > first[1] > first[2] > 0.0
    assert frequencies.axial(1e-9, mass=150.0) < frequencies.axial(1e-9)
    assert frequencies.axial(1e-9, mass=110.0) == frequencies.axial(1e-9)
    twist = [frequencies.torsional(e) for e in (3e-8, 4e-8)]
    chain = axial_chain(
        1e-9 * frequencies.axial_shares,
        np.full(6, 110.0),
        frequencies.engine_file.flywheel.mass,
        frequencies.engine_file.thrust_bearing.section_index,
        frequencies.engine_file.thrust_bearing.stiffness,
    )
    modes = chain.chain.modes()
    assert frequencies.axial(1e-9) == close(modes.frequencies[modes.rigid], rel=1e-9)
    # Without a stiffness to ground the frequency goes with the root of the stiffness.
    assert twist[0] / twist[1] == close((4.0 / 3.0) ** 0.5, rel=1e-9)


def test_the_first_torsional_frequency_is_no_couplings():
    engine = load_engine(Path(__file__).parents[2] / "data/engines/8l32-42-damper.toml")
    shares = np.full(8, 1.0)
    frequencies = EngineFrequencies(engine, shares, shares, 110.0, throw_inertias=np.full(8, 8.0))
    chain = engine_torsional_chain(engine, 2e-8 * shares, frequencies.throw_inertias)
    coupling, first = chain.chain.modes().elastic_frequencies[:2]
    assert frequencies.torsional(2e-8) == close(first, rel=1e-9)
    assert first > 3.0 * coupling
    # The coupling stays as it is while the throws become softer.
    assert frequencies.torsional(8e-8) < 0.7 * first


@pytest.mark.further
def test_frequency_limits(run, path, frequencies, short_search, monkeypatch):
    monkeypatch.setattr(searches, "engine_frequencies", lambda _: frequencies)
    model = ComplianceModel.load(path)
    needed = frequencies.torsional(3.9e-8)
    found = json.loads(
        run(
            *(path, "--minimize", "web_thickness", "--engine", ENGINE),
            *("--first-torsional-frequency", f">= {needed:.9f} Hz"),
            *("--first-axial-frequency", ">= 60 Hz", "--json"),
        )
    )
    axial, torsional = found["limits"]
    assert (axial["name"], axial["sign"], axial["unit"]) == ("first axial frequency", ">=", "Hz")
    e, m = (found["responses"][name] for name in ("axial_compliance", "mass"))
    corners = [frequencies.axial(e[one], m[two]) for one in ENDS for two in ENDS]
    assert axial["worst"] == close(min(corners), rel=1e-12)
    assert not axial["active"]
    assert torsional["worst"] == close(needed, rel=1e-6)
    assert torsional["active"]
    assert found["responses"]["torsional_compliance"]["upper"] == close(3.9e-8, rel=1e-6)
    assert 0.050 < found["value"] < 0.090
    assert found["remarks"][-1].startswith(f"of the throw of {ENGINE}, the ratio")
    torsional = frequency_limit("torsional", frequencies, model, 30.0)
    assert torsional.quantities == ("torsional_compliance",)
    alone = ComplianceModel(responses={"axial_compliance": model.responses["axial_compliance"]})
    assert frequency_limit("axial", frequencies, alone, 30.0).quantities == ("axial_compliance",)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("arguments", "match"),
    [
        (("--limit", "axial_compliance"), "--limit: given 'axial_compliance'; allowed is NAME <= "),
        (("--limit", "axial_compliance <= 1"), "axial_compliance: given '1', a bare number"),
        (("--limit", "hue <= 1 mm"), "--limit: given 'hue'; allowed are the responses axial_comp"),
        (("--limit", "mass <= 1 mm"), "mass: given '1 mm', which is no mass"),
        (("--limit", "tilt_stiffness_ratio <= soft"), "given 'soft'; write a plain number"),
        (("--first-axial-frequency", ">= 40 Hz"), "frequency: given without --engine"),
        (("--engine", ENGINE), "--engine: given '6chn25-34' without a frequency"),
        (("--engine", ENGINE, "--first-axial-frequency", "<= 40 Hz"), "--first-axial-frequency:"),
        (("--engine", ENGINE, "--first-axial-frequency", ">= -4 Hz"), "allowed is a frequency"),
        (("--fixed", "web_width=400mm"), "fixed: given 400 mm for web_width; allowed is 270 mm"),
        (("--limit", "axial_compliance <= 0.1e-9 m/N"), "that no throw of the model's family"),
    ],
)
def test_unusable_searches(run, path, arguments, match):
    with pytest.raises(InputError, match=match):
        run(path, "--minimize", "web_thickness", *arguments)


def test_an_unknown_name_to_minimize(run, path):
    with pytest.raises(InputError, match="--minimize: given 'hue'; allowed are the responses"):
        run(path, "--minimize", "hue")


def test_a_frequency_needs_its_compliance(run, path):
    ComplianceModel(responses={"mass": ComplianceModel.load(path).responses["mass"]}).save(path)
    with pytest.raises(InputError, match="given for a model without torsional_compliance"):
        run(
            *(path, "--minimize", "mass", "--engine", ENGINE),
            *("--first-torsional-frequency", "40 Hz"),
        )


AXIAL, TORSIONAL = "first_axial_frequency", "first_torsional_frequency"
VARY = {"vary": ["web_width=300mm..380mm"]}


@pytest.mark.parametrize(
    ("changes", "unused", "used"),
    [
        ({}, {"flywheel", "thrust_bearing", "engine"}, set()),
        ({AXIAL: ">= 40 Hz"}, {"flywheel.inertia", "rod", "gas"}, {"flywheel.mass"}),
        ({TORSIONAL: ">= 40 Hz"}, {"flywheel.mass", "gas"}, {"flywheel.inertia", "rod.mass"}),
        # The search of throws has both frequencies among its responses.
        ({AXIAL: ">= 40 Hz", **VARY}, {"gas"}, {"flywheel.mass", "flywheel.inertia"}),
        ({"limits": [f"{AXIAL} >= 40 Hz"]}, {"flywheel", "engine"}, set()),
        ({"limits": [f"{TORSIONAL} >= 40 Hz"], **VARY}, {"study"}, {"flywheel.inertia"}),
        ({AXIAL: ">= 40 Hz", TORSIONAL: ">= 40 Hz"}, {"gas"}, {"flywheel.mass", "rod.mass"}),
    ],
)
def test_an_optimum_uses_what_its_frequencies_depend_on(changes, unused, used):
    asked = {
        "vary": None,
        "minimize": "mass",
        "limits": None,
        AXIAL: None,
        TORSIONAL: None,
    } | changes
    named = not_used_of("6chn25-34", command_use("optimum", asked))
    assert unused <= {*named}
    assert not {part for field in used for part in (field, field.partition(".")[0])} & {*named}
