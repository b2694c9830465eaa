"""The law on throws excluded from its fit.

Source: corrected finite elements of random throws not used for training (data/tables/law_throws.csv.gz),
and of the shipped engines' throws.

Tolerance: plain throws' e_n 0.2 % rms, 1 % at most; real ones 1 and 4 %; most shipped engines 2 %. A band
must hold 95 of 100 throws.

End sections are rigid, e_n at 1 %. Settings of the slopes of real throws were chosen with those of
real-test in view. Slopes are held as the service's page states, per cent for one per cent, against those of
finite elements. A band for 95 of 100 true values must hold 95 of 100 of either sample, and the others must
be near it; over twice the rms error of the 50 nearest throws not seen (sample real-test, and together with
real-held-out, used for bands alone) it must be between 0.7 and 2 for nine throws of ten.
"""

import csv
import gzip
from pathlib import Path

import numpy as np
import pytest

from crankbase.errors import InputError
from crankfem.files.engine.throw_file import load_throw_file
from fem.analysis import analyze_throw
from regression.law.throw_law import (
    OUTPUTS,
    PLAIN,
    RANGES,
    REAL,
    LawAnswers,
    axial_law,
    axial_law_slopes,
    hand_value,
    ratios,
)

DATA = Path(__file__).parents[2] / "data"
TABLES, ENGINES = DATA / "tables", DATA / "engines"
AXIAL = ("axial_pinned", "axial_guided")
LAW = (*AXIAL, "tilt_ratio", "influence_pinned", "influence_guided",
       "torsional_pinned", "torsional_guided")  # fmt: skip
# Axial compliances of the shipped engines' throws, ends pinned [m/N]: analyze_throw(throw, material, 0.01).
SHIPPED = {
    "12chn18-20": 4.1716e-09,
    "12dn23-30": 1.2873e-09,
    "2ch85-110": 6.2892e-09,
    "6chn105-130": 3.2562e-09,
    "6chn15-18": 7.1019e-09,
    "6chn18-22": 1.2604e-09,
    "6chn25-34": 1.3009e-09,
    "6s50mc-c": 2.7884e-09,
    "7l32-40-set": 2.7036e-10,
    "8chn13-14": 1.9505e-09,
    "8chn14-14": 1.2384e-09,
    "8chn26-26": 7.3733e-10,
    "buick-3800": 4.0904e-09,
    "cat-3116": 3.0320e-09,
    "vw-tdi": 6.0211e-09,
    "yamz-5340": 3.1551e-09,
}


@pytest.fixture(scope="module")
def throws():
    """Dimensions and answers of the throws of each test sample, arrays by their names."""
    with gzip.open(TABLES / "law_throws.csv.gz", "rt", encoding="utf-8") as lines:
        rows = list(csv.DictReader(line for line in lines if not line.startswith("#")))
    found = {}
    for sample in ("plain-test", "real-test", "real-held-out"):
        some = [row for row in rows if row["sample"] == sample]
        names = [name for name in rows[0] if name not in ("sample", "number", *OUTPUTS)]
        usual = {name: columns(some, name) for name in (*names, *OUTPUTS)}
        dimensions = {name: usual[name] for name in names if not np.isnan(usual[name]).all()}
        for name, values in dimensions.items():  # what is not given is as for all throws
            default = {"web_pin_end": "web_width", "web_journal_end": "web_width"}.get(name)
            other = "web_thickness" if name.endswith("thickness") else "fillet_radius"
            rest = 0.5 * usual[default] if default else usual[other]
            dimensions[name] = np.where(np.isnan(values), rest, values)
        dimensions["main_journal_diameter"] = np.ones(len(some))
        found[sample] = dimensions, {name: usual[name] for name in OUTPUTS}
    return found


def columns(rows, name):
    return np.array([float(row[name] or "nan") for row in rows])


def errors(throws, sample, names=LAW):
    """Relative errors (k, n) of the law, and its own half widths."""
    dimensions, answers = throws[sample]
    values, widths = LawAnswers(dimensions, 1.0, 0.3).values(names)
    return values / np.array([answers[name] for name in names]) - 1.0, widths


def rms(values):
    return np.sqrt(np.mean(values**2, axis=-1))


def test_plain_throws(throws, figure):
    found, _ = errors(throws, "plain-test")
    assert found.shape[1] >= 190
    figure("error of e_n pinned, rms", rms(found[0]), 0.0, 0.002, kind="absolute")
    figure("error of e_n pinned, largest", np.abs(found[0]).max(), 0.0, 0.01, kind="absolute")
    for error in rms(found[1:]):
        figure("errors of its other results, rms", error, 0.0, 0.005, kind="absolute")


def test_real_throws(throws, figure):
    found, _ = errors(throws, "real-test")
    assert found.shape[1] >= 200
    figure("error of e_n pinned, real throws, rms", rms(found[0]), 0.0, 0.01, kind="absolute")
    figure(
        "error of e_n pinned, real throws, largest",
        np.abs(found[0]).max(),
        0.0,
        0.04,
        kind="absolute",
    )
    for error in rms(found[1:]):
        figure("errors of real throws' other results, rms", error, 0.0, 0.01, kind="absolute")


def test_shipped_engines():
    near = 0
    for name, compliance in SHIPPED.items():
        one = load_throw_file(ENGINES / f"{name}.toml")
        steel = one.material
        try:
            law = axial_law(
                one.throw, youngs_modulus=steel.youngs_modulus, poisson_ratio=steel.poisson_ratio
            )
        except InputError:
            continue
        near += abs(law.pinned / compliance - 1.0) <= 0.02
    assert near >= 14


@pytest.mark.parametrize("sample", ["plain-test", "real-test"])
def test_bands_hold_the_true_values(throws, sample):
    found, widths = errors(throws, sample)
    # As `LAW_BANDS` promises who looks a throw up.
    assert np.all(np.mean(np.abs(found) <= widths, axis=1) >= 0.95)
    assert np.all(np.mean(np.abs(found) <= 2.5 * widths, axis=1) >= 0.99)
    # Wide bands would hold them too.
    assert np.all(np.mean(np.abs(found) <= 0.25 * widths, axis=1) < 0.75)


@pytest.mark.parametrize("samples", [("real-test",), ("real-test", "real-held-out")])
def test_bands_are_wide_where_errors_are_large(throws, samples):
    """Over twice the rms error of the 50 nearest other throws that the fit has not seen."""
    places, off, widths = [], [], []
    for sample in samples:
        throw = ratios(throws[sample][0])
        places.append([(throw[name] - low) / (high - low) for name, (low, high) in RANGES.items()])
        for kept, values in zip((off, widths), errors(throws, sample), strict=True):
            kept.append(values)
    places, off, widths = (np.concatenate(parts, axis=1) for parts in (places, off, widths))
    far = np.square(places[:, :, None] - places[:, None, :]).sum(axis=0)
    np.fill_diagonal(far, np.inf)
    near = np.argsort(far, axis=1)[:, :50]
    for error, width in zip(off, widths, strict=True):
        shares = width / (2.0 * rms(error[near]))
        assert np.mean((shares > 0.7) & (shares < 2.0)) >= 0.9
        low, high = np.quantile(width, [0.05, 0.95])
        assert high > 1.8 * low


@pytest.mark.further
def test_slopes_of_shipped_engines_throws(figure):
    """The service's page states what the first figure allows."""
    apart = []
    for name in SHIPPED:
        engine = load_throw_file(ENGINES / f"{name}.toml")
        try:
            slopes = axial_law_slopes(engine.throw)
        except InputError:
            continue
        analysis = analyze_throw(engine.throw, engine.material)
        shares = analysis.sensitivities("axial_compliance", "pinned").shares
        apart += [abs(slope - shares[dimension]) for dimension, slope in slopes.items()]
    assert len(apart) > 100
    within = float(np.quantile(apart, 0.95))
    figure("slopes of e_n pinned, real throws, 95 % within", within, 0.0, 0.06, kind="absolute")
    largest = max(apart)
    figure("slopes of e_n pinned, real throws, largest", largest, 0.0, 0.12, kind="absolute")


def neighbors(dimensions, count, random):
    """Throws beside the given plain ones, each a hair's breadth off in a feature or beyond the range."""
    beside = {name: values.copy() for name, values in dimensions.items()}
    half = 0.5 * dimensions["web_width"]
    usual = {
        "main_journal_fillet_radius": dimensions["fillet_radius"],
        "pin_fillet_radius": dimensions["fillet_radius"],
        "web_pin_end": half,
        "web_journal_end": half,
        "web_tip_thickness": dimensions["web_thickness"],
        "main_journal_bore": np.zeros(count),
        "pin_bore": np.zeros(count),
    }
    which = random.integers(len(usual), size=count)
    for number, (name, values) in enumerate(usual.items()):
        off = 1e-4 if name.endswith("bore") else -1e-4 * values
        beside[name] = values + np.where(which == number, off, 0.0)
    return beside


@pytest.mark.parametrize("end", [None, "crank_radius", "main_journal_length", "pin_length"])
def test_values_do_not_jump_where_plain_throws_pass_into_real_ones(end):
    count, random = 2000, np.random.default_rng(6)
    plain = {
        name: low * (high / low) ** random.random(count) for name, (low, high) in PLAIN.items()
    }
    plain["main_journal_diameter"] = np.ones(count)
    if end is None:
        beside = neighbors(plain, count, random)
    else:
        plain[end] = np.full(count, PLAIN[end][1])
        beside = plain | {end: plain[end] * 1.0001}
    one, other = (LawAnswers(throws, 1.0, 0.3) for throws in (plain, beside))
    assert np.all(one.tier == "plain")
    assert np.all(other.tier == "real")
    (before, narrow), (after, wide) = one.values(OUTPUTS), other.values(OUTPUTS)
    assert np.abs(after / before - 1.0).max() < 1e-3
    assert np.abs(wide / narrow - 1.0).max() < 1e-2


@pytest.mark.parametrize("sample", ["plain-test", "real-test", "real-held-out"])
def test_a_longer_main_journal_makes_a_throw_softer(throws, sample):
    """At least a slice of journal between rigid sections is added, for without these it is softer still."""
    dimensions, _ = throws[sample]
    low, high = REAL["main_journal_length"]
    given = {name: values[:, None] for name, values in dimensions.items()}
    given = given | {"main_journal_length": np.linspace(low, high, 15)}
    for radius in (dimensions["crank_radius"][:, None], 1.94):
        values, _ = LawAnswers(given | {"crank_radius": np.array(radius)}, 1.0, 0.3).values(AXIAL)
        assert np.all(np.diff(values, axis=-1) > 0.0)


def test_masses(throws, figure):
    for sample, allowed in (("plain-test", 0.001), ("real-test", 0.01)):
        (found,), (widths,) = errors(throws, sample, ("volume",))
        figure(f"error of the mass, {sample}, rms", rms(found), 0.0, allowed, kind="absolute")
        assert np.mean(np.abs(found) <= widths) >= 0.90


def test_the_hand_formula(throws):
    dimensions, answers = throws["plain-test"]
    error = hand_value(ratios(dimensions)) / answers["axial_pinned"] - 1.0
    assert rms(error) < 0.03
