"""Results and inputs show themselves in a few lines, signatures in words of ours."""

import dataclasses
import inspect
import pydoc
import re
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import crankfem as cf
from crankbase.summaries import summarized, summary_text

MOST = 400
# What a field may hold of which the usual text of a dataclass stays short.
SHORT = re.compile(r"(?:str|int|float|complex|bool|None|Literal|[|'\[\], ]|'[a-z -]+')+")
# Inputs that hold other inputs, and few of them.
NESTED = {"CrossheadEngine", "EngineMagnifier", "Limit", "MainBearings", "ShaftCone"}


@given(st.lists(st.text(max_size=90), max_size=60), st.from_regex(r"\A[A-Z][a-z]{0,30}\Z"))
def test_a_text_keeps_to_three_lines(parts, name):
    parts = [re.sub(r"\s", " ", part)[:90] for part in parts]
    text = summary_text(name, parts)
    assert text.startswith(name)
    assert len(text.splitlines()) <= 3 or any(len(part.splitlines()) > 1 for part in parts)
    assert len(text) <= MOST


@pytest.mark.parametrize(
    ("value", "shown"),
    [
        (312.4567, "value 312.5 m"),
        (3, "value 3 m"),
        (None, ""),
        (float("nan"), ""),
        (lambda: 2.0, "value 2 m"),
        (np.array([1.0, 2.0]), "value (1, 2) m"),
        (np.arange(60.0), "value 0 to 59 m (60)"),
        (np.full((2, 30), 7.0), "value 7 m (2 x 30)"),
        (np.append(np.arange(8.0), [np.inf, np.nan]), "value 0 to 7 m (10)"),
        (np.full(8, np.nan), "value 8 m"),
        (np.arange(8) * (3.0 + 4.0j), "value up to 35 m (8)"),
        (np.array([]), "value none m"),
        (("a sentence, which nobody reads here", "another"), "value 2"),
        ({"one": 1}, "value 1"),
    ],
)
def test_how_values_are_written(value, shown):
    @summarized("value [m]")
    class Found:
        def __init__(self):
            self.value = value

    text = repr(Found())
    assert text.removeprefix("Found(").removesuffix(")") in {shown, shown.removesuffix(" m")}


def test_attributes_of_attributes_and_labels():
    @summarized("one.size [m]", "other: two.size [N]", "none.size")
    class Found:
        one, two, none = SimpleNamespace(size=1.0), SimpleNamespace(size=2.0), None

    assert repr(Found()) == "Found(size 1 m, other 2 N)"
    assert Found()._repr_html_().count("<tr>") == 2


def test_every_public_class_shows_itself_briefly(public_classes):
    for name, one in public_classes.items():
        if issubclass(one, Exception) or hasattr(one, "_repr_html_"):
            continue
        assert dataclasses.is_dataclass(one), name
        kinds = (
            {} if name in NESTED else {own.name: str(own.type) for own in dataclasses.fields(one)}
        )
        for field, kind in kinds.items():
            kind = re.sub(r"<class '(.*)'>", r"\1", kind)
            assert SHORT.fullmatch(kind.replace("typing.", "")), (name, field, kind)


def test_inputs_and_their_results(dimensions):
    throw = cf.CrankThrow(**dimensions)
    chain = cf.Chain(np.ones(30), np.ones(29))
    engine = cf.load_engine("6chn25-34")
    mechanism = cf.load_mechanism("8chn26-26")
    run = cf.run_mechanism(mechanism)
    excitation = cf.OrderExcitation(np.arange(1.0, 25.0), [1.0, 2.0], np.ones((24, 2, 30)))
    response = cf.forced_response(cf.damped(chain, loss_factor=0.1), excitation)
    found = [throw, chain, chain.modes(), engine, engine.material, mechanism, run, run.torque]
    found += [
        *run.balance.rows,
        run.balance,
        excitation,
        response,
        cf.axial_formulas(throw)["TsNIIMF"],
    ]
    found += [*run.crankpins, run.forces, mechanism.layout, *mechanism.pressure]
    for one in found:
        assert len(repr(one)) <= MOST
        assert len(repr(one).splitlines()) <= 3
        assert str(one) == repr(one)
        assert " at 0x" not in repr(one)
        assert one._repr_html_().startswith(f"<table><caption>{type(one).__name__}</caption><tr>")


def test_an_input_shows_what_was_given(dimensions):
    throw = cf.CrankThrow(**dimensions)
    assert eval(repr(throw), {"CrankThrow": cf.CrankThrow}) == throw
    assert "web_outline" not in repr(throw)
    assert "<th>pin_diameter</th><td>0.18 m</td>" in throw._repr_html_()
    many = cf.Crankshaft([throw] * 9, crank_angles_deg=[0.0] * 9)
    assert len(repr(many)) <= MOST


def members(name, one):
    yield name, one
    if inspect.isclass(one):
        for own, member in vars(one).items():
            if callable(member) and not own.startswith("_"):
                yield f"{name}.{own}", member


def test_no_signature_shows_an_address(public):
    for name, one in public.items():
        for own, member in members(name, one):
            if callable(member) and not (inspect.isclass(member) and issubclass(member, Exception)):
                assert " at 0x" not in str(inspect.signature(member)), own


def test_models_are_described_in_our_words():
    text = str(inspect.signature(cf.CrankThrow))
    assert "crank_radius: float [m], " in text
    assert "pin_fillet_radius: float [m] | None = None, " in text
    assert "counterweight: Counterweight | None = None" in text
    page = pydoc.render_doc(cf.CrankThrow, renderer=pydoc.plaintext)
    assert "pydantic_" not in page
    assert "model_" not in page
    names = dir(cf.STEEL)
    assert {"changed", "density", "shear_modulus"} <= set(names)
    assert not [name for name in names if name.startswith("model_")]
    assert cf.STEEL.model_fields_set  # hidden, not gone


def test_a_path_is_no_longer_than_a_line(tmp_path):
    @summarized("path")
    class Found:
        path = Path("/" + "deep/" * 60)

    assert len(repr(Found())) < 100
