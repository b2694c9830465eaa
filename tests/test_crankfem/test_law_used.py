"""Where the law is told and used: check, formulas, lookup, and as a source of an engine's compliances."""

import json

import numpy as np
import pytest

from comparing import close
from crankbase.errors import InputError
from crankfem.analyses.shaft.sources import (
    axial_sources,
    compliances_in_shaft,
    law_values,
    refuse_law,
    source_spread,
    torsional_sources,
)
from crankfem.analyses.throw.law_record import (
    LAW_BANDS,
    law_answers,
    law_lookups,
    law_record,
    law_sentence,
)
from crankfem.cli.arguments import law_throw
from crankfem.files.engine.engine_file import load_engine
from crankfem.files.engine.throw_file import load_throw
from crankfem.files.reading.data_files import input_path
from fem.analysis import analyze_throw
from fem.angle_law import AngleLaw
from fem.material import STEEL
from fem.supports import Neighbors
from geometry.throw import CrankThrow
from regression.law.throw_law import axial_law, torsional_law
from regression.response_kinds import NEEDED, ThrowLengths, end_reactions

PLAIN = {
    "crank_radius": 0.170,
    "main_journal_diameter": 0.220,
    "pin_diameter": 0.180,
    "main_journal_length": 0.120,
    "pin_length": 0.139,
    "web_width": 0.300,
    "web_thickness": 0.068,
    "fillet_radius": 0.012,
}
THROW = CrankThrow(**PLAIN)
OUTSIDE = CrankThrow(**PLAIN | {"crank_radius": 0.480})
PAIRS = [f"{name}={1e3 * value:g} mm" for name, value in PLAIN.items()]
# Covered by the plain tier of the law; its throw has bores of none and obround webs.
ENGINE = "6chn25-34"


def test_answers_are_the_laws_with_their_bands():
    found, law = law_answers(THROW, STEEL), axial_law(THROW, youngs_modulus=STEEL.youngs_modulus)
    own = found["axial_compliance"]
    assert (own["lower"], own["upper"]) == close(law.band)
    assert own["value"] == law.pinned
    assert found["torsional_compliance_guided"]["value"] == close(
        torsional_law(THROW, youngs_modulus=STEEL.youngs_modulus).guided
    )
    assert {one["unit"] for one in found.values()} == {"m/N", "rad/(N m)", ""}


def test_between_neighbors_the_band_is_that_of_all_three_numbers():
    found, law = law_answers(THROW, STEEL, 240.0), axial_law(THROW, youngs_modulus=2.1e11)
    numbers = (law.guided, law.pinned, law.ratio, law.influence_guided, law.influence_pinned)
    expected = float(AngleLaw(*numbers).axial(120.0))
    own = found["axial_compliance"]
    assert own["value"] == close(expected * 2.1e11 / STEEL.youngs_modulus, rel=1e-12)
    assert own["lower"] < own["value"] < own["upper"]
    assert own["support"] == "between neighbors at 240 deg"
    # Wider than that of either end by itself, for rho has a band too.
    assert own["upper"] / own["value"] > found["axial_compliance_guided"]["upper"] / law.guided * (
        STEEL.youngs_modulus / 2.1e11
    )


def test_the_sentence_tells_value_and_band_or_the_ratio_outside():
    record = law_record(THROW, STEEL)
    own = record["answers"]["axial_compliance"]
    width = 100.0 * (own["upper"] / own["value"] - 1.0)
    sentence = law_sentence(record)
    assert f"e_n {1e9 * own['value']:.4g}e-9 m/N within {width:.2g} %" in sentence
    assert json.loads(json.dumps(record)) == record
    refused = law_record(OUTSIDE, STEEL)
    assert refused["answers"] is None
    assert law_sentence(refused).startswith("The law does not apply to this throw: ")
    assert "crank_radius" in refused["reason"] or "plain" in refused["reason"]


def test_looked_up_reactions_are_those_of_the_few_numbers_too():
    """The law's superelement beside what makes reactions of a model's equations."""
    found = law_lookups(THROW, STEEL)
    value = {name: one.value for name, one in found.answers.items()}
    lengths = ThrowLengths(THROW.length, THROW.length / 2.0, THROW.crank_radius)
    force = np.array([2e4, -1e5, 0.0])
    own = {NEEDED["pinned"][0]: value["influence_coefficient"] / value["axial_compliance"]}
    loads = end_reactions(own, lengths, force)
    by_law = found.reactions(force, "pinned")
    assert by_law.left.force == close(loads[:3], abs=1e-6)
    assert by_law.left.moment == close(loads[3:6], abs=1e-6)
    for support in ("pinned", "guided", Neighbors(120.0, 120.0)):
        answer = found.reactions(force, support)
        # Of the axial reaction the band is never 0, and narrow.
        band = answer.band.left.force[2] / abs(answer.left.force[2])
        assert 1e-4 < band < 0.05, support
        assert answer.left.force + answer.right.force == close(-force, abs=1e-7)


@pytest.mark.parametrize(
    ("pairs", "match"),
    [
        (["crank_radus=170mm"], r"crank_radus: unknown dimension; did you mean crank_radius\?"),
        (["crank_radius=170"], "crank_radius: given '170', a bare number"),
        (["crank_radius=170mm"], "main_journal_diameter: missing"),
        (["crank_radius"], "crank_radius: given without a value"),
        ([*PAIRS, "web_outline=round"], "web_outline"),
    ],
)
def test_throws_on_the_command_line(pairs, match):
    with pytest.raises(InputError, match=match):
        law_throw(pairs)


def test_a_throw_of_pairs_or_of_an_engine_that_they_change():
    assert law_throw(PAIRS) == (THROW, STEEL)
    throw, material = load_throw(ENGINE)
    assert law_throw(["web_width=310mm"], ENGINE) == (throw.changed(web_width=0.310), material)


def test_lookup_law(call):
    out = call("lookup", "law", *PAIRS, "--gamma", "120 deg", "--pin-force", "0, -100 kN, 0").out
    assert LAW_BANDS in out
    assert "Axial reaction neighbors 120 deg: within" in out
    found = call("lookup", "law", *PAIRS, "--json").json()
    assert (
        found["axial_compliance"]["value"] == law_answers(THROW, STEEL)["axial_compliance"]["value"]
    )
    assert "refused" not in found


def test_check_and_formulas_tell_the_law(call):
    value = law_answers(*load_throw(ENGINE))["axial_compliance"]["value"]
    assert (
        f"By the law, without finite elements: e_n {1e9 * value:.4g}e-9"
        in call("check", ENGINE).out
    )
    record = call("check", ENGINE, "--json").json()
    assert record["law"]["answers"]["axial_compliance"]["value"] == value
    out = call("formulas", ENGINE, "--no-fe").out
    assert "the law" in out
    assert "The law, fitted to finite elements with rigid end sections, has a band of" in out
    # Axial compliances stand beside finite elements between neighbors, torsional ones beside pinned ends.
    assert out.count(", and omits the bending of sections between neighbors.") == 1


def test_throws_outside_are_told_by_formulas_too(call, tmp_path):
    path = tmp_path / "long.toml"
    lines = (
        f'{name} = "{1e3 * value:g} mm"' for name, value in (PLAIN | {"crank_radius": 0.48}).items()
    )
    path.write_text("[throw]\n" + "\n".join(lines), encoding="utf-8")
    assert "The law does not apply to this throw: " in call("check", path).out
    assert "Left out: the law, " in call("formulas", path, "--no-fe").out


# --------------------------------------------------------------------------- source of an engine


@pytest.fixture(scope="module")
def engine():
    return load_engine(input_path(ENGINE))


@pytest.fixture(scope="module")
def analysis(engine):
    return analyze_throw(engine.throw, engine.material, 0.1)


def test_the_law_as_a_source_is_its_pinned_value_times_the_throws_ratios(engine, analysis):
    shaft = compliances_in_shaft(engine, analysis)
    for kind, sources in (("axial", axial_sources), ("torsional", torsional_sources)):
        values, remark = sources(engine, analysis, shaft, None)["law"]
        pinned = getattr(analysis, f"{kind}_compliance")("pinned")
        own = law_values(engine, f"{kind}_compliance")[engine.throw]
        assert values == close(own.value * getattr(shaft, kind) / pinned, rel=1e-12)
        assert remark.startswith("the law's pinned value, times each throw's ratio")
        spread = source_spread(engine, kind, "law", analysis, shaft, None)
        assert (spread.low, spread.high) == close((own.lower / own.value, own.upper / own.value))


def test_engines_whose_throws_the_law_does_not_cover_refuse_it(tmp_path, call):
    text = input_path(ENGINE).read_text(encoding="utf-8")
    path = tmp_path / "long.toml"
    path.write_text(text.replace('axial_source = "fe"', 'axial_source = "law"'), encoding="utf-8")
    refuse_law(load_engine(path))
    assert call("check", path).code == 0
    bored = text.replace('axial_source = "fe"', 'axial_source = "law"').replace(
        "[throw]", '[[throw.oil_holes]]\npart = "pin"\ndiameter = "20 mm"\n\n[throw]'
    )
    path.write_text(bored, encoding="utf-8")
    with pytest.raises(
        InputError, match=r"vibration.axial_source: given 'law', which does not apply to"
    ):
        refuse_law(load_engine(path))
