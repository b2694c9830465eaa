"""Public names, and how results show themselves."""

import dataclasses
import doctest
import importlib
import inspect
import pkgutil
import pydoc
import re
import sys
from collections import Counter
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import crankfem as cf
from crankbase.summaries import summarized, summary_text
from crankfem.analyses.provenance import provenance

HEAVY = (
    *("gmsh", "vtk", "vtkmodules", "pyvista", "matplotlib", "skfem", "pypardiso", "meshio"),
    *("pandas", "xarray", "plotly"),
)


TOPICS = {name: one for name in cf.__all__ if inspect.ismodule(one := getattr(cf, name))}


def test_every_public_thing_has_one_place():
    packages = [cf, *TOPICS.values()]
    names = Counter(name for one in packages for name in one.__all__)
    assert [name for name, count in names.items() if count > 1] == []
    things = Counter(id(getattr(one, name)) for one in packages for name in one.__all__)
    assert max(things.values()) == 1


def test_the_top_is_small_and_its_topics_are_its_folders():
    assert len(cf.__all__) - len(TOPICS) <= 70
    folder = Path(cf.__file__).parent
    assert set(TOPICS) == {path.parent.name for path in folder.glob("*/__init__.pyi")}
    for one in TOPICS.values():
        assert one is importlib.import_module(one.__name__)


def test_no_module_of_the_package_takes_a_public_name():
    """Importing a submodule would put it in the place of the name."""
    modules = {found.name for found in pkgutil.iter_modules(cf.__path__)}
    assert modules & set(cf.__all__) == set(TOPICS)


@pytest.mark.parametrize("name", TOPICS)
def test_a_topic_shows_the_way_in(name):
    """That its example runs is tested with all others in docstrings."""
    (example,) = doctest.DocTestFinder(recurse=False).find(TOPICS[name])
    assert 3 <= len(example.examples) <= 8
    assert any(name in one.source for one in example.examples)


@pytest.mark.slow
def test_all_ways_to_a_name_of_a_topic(spawn):
    code = (
        "from crankfem.chains import with_damper; from crankfem import chains; import crankfem as cf; "
        "assert cf.chains is chains and cf.chains.with_damper is with_damper is chains.with_damper"
    )
    answer = python(spawn, code)
    assert answer.code == 0, answer.err


@pytest.mark.parametrize("module", [cf, cf.chains])
def test_only_public_names_are_listed(module):
    assert [name for name in dir(module) if not name.startswith("__")] == module.__all__


def test_the_version_is_the_one_that_results_record():
    assert cf.__version__ == provenance().version


def test_an_unknown_name():
    with pytest.raises(AttributeError, match="module 'crankfem' has no attribute 'magic'"):
        cf.magic  # noqa: B018
    with pytest.raises(AttributeError, match=r"module 'crankfem\.chains' has no attribute 'magic'"):
        cf.chains.magic  # noqa: B018


def python(spawn, code, **options):
    return spawn("-c", code, command=[sys.executable, "-P"], **options)


@pytest.mark.slow
@pytest.mark.parametrize(
    "code",
    [
        "import crankfem",
        "import crankfem as cf; cf.CrankThrow, cf.STEEL, cf.InputError, dir(cf)",
        "import crankfem as cf; cf.Chain([0.1, 0.78], [9e5]).modes(); cf.harmonics([0, 1, 0, -1])",
        "import crankfem as cf; cf.ComplianceModel",
        "import crankfem as cf; cf.axial_formulas, cf.torsional_formulas",
        "from crankfem import chains, formulas, limits; chains.with_gear, limits.given_limit",
    ],
)
def test_light_work_loads_no_heavy_library(spawn, code):
    answer = python(spawn, f"{code}; import sys; print(*(n for n in {HEAVY} if n in sys.modules))")
    assert answer.code == 0, answer.err
    assert answer.out.strip() == ""


@pytest.mark.parametrize("kind", ["package", "module"])
@pytest.mark.parametrize("name", ["fem", "geometry", "regression", "dynamics"])
def test_a_foreign_package_in_front_is_told(spawn, spawn_environment, tmp_path, name, kind):
    foreign = tmp_path / "foreign"
    place = foreign / name / "__init__.py" if kind == "package" else foreign / f"{name}.py"
    place.parent.mkdir(parents=True)
    place.write_text("value = 1\n", encoding="utf-8")
    paths = spawn_environment()["PYTHONPATH"]
    environment = spawn_environment(PYTHONPATH=f"{foreign}:{paths}")
    answer = python(spawn, "import crankfem", env=environment)
    assert answer.code == 1
    last = answer.err.strip().splitlines()[-1]
    assert last.startswith(f"ImportError: crankfem needs its own package '{name}'")
    assert str(place) in last


def test_a_foreign_package_behind_does_no_harm(spawn, spawn_environment, tmp_path):
    (tmp_path / "foreign" / "fem").mkdir(parents=True)
    (tmp_path / "foreign" / "fem" / "__init__.py").write_text("", encoding="utf-8")
    paths = spawn_environment()["PYTHONPATH"]
    environment = spawn_environment(PYTHONPATH=f"{paths}:{tmp_path / 'foreign'}")
    answer = python(spawn, "import crankfem as cf; cf.STEEL", env=environment)
    assert answer.code == 0, answer.err


ANGLES = {
    *("angle", "angles", "crank_angle", "crank_angles", "bank_angle", "bank_angles", "shaft_angle"),
    *("shaft_angles", "firing", "firing_angle", "firing_angles", "throw_angles", "start_angle"),
    *("phases", "thrust_phases", "torque_phases", "directions", "direction", "resultant_direction"),
    *("peak_angle", "maximum_angle", "force_angle", "top_angle", "bottom_angle", "largest_at"),
    *("stopped_at", "cycle_angle", "fit_from", "fit_to"),
    *("combustion_start", "combustion_duration", "intake_closes", "exhaust_opens"),
    *("overlap_begins", "overlap_ends"),
}
# Their files have the same fields, with units; beyond their ranges of radians they refuse.
OF_FILES = ("Counterweight", "FurtherPin", "OilHole")


@pytest.mark.parametrize("package", [cf, *TOPICS.values()], ids=lambda one: one.__name__)
def test_public_angles_are_degrees_by_name(package):
    """Arguments, fields, properties and arguments of methods; `_deg` tells the unit of an angle."""
    for name in set(package.__all__) - {*OF_FILES}:
        thing = getattr(package, name)
        if inspect.isclass(thing) and issubclass(thing, Exception):
            continue
        named = {}
        if inspect.isroutine(thing) or inspect.isclass(thing):
            named[name] = set(inspect.signature(thing).parameters)
        if inspect.isclass(thing):
            own = {key: one for key, one in inspect.getmembers(thing) if not key.startswith("_")}
            named[f"{name}.*"] = set(own)
            named |= {
                f"{name}.{key}": set(inspect.signature(one).parameters)
                for key, one in own.items()
                if inspect.isfunction(one) or inspect.ismethod(one)
            }
        for place, names in named.items():
            assert not ANGLES & names, f"{place}: {ANGLES & names}"


def test_degrees_are_refused_where_radians_of_a_file_stand():
    with pytest.raises(cf.InputError, match=r"angle: given .* deg"):
        cf.throws.Counterweight(outer_radius=0.27, angle=120.0)
    with pytest.raises(cf.InputError, match=r"angle: given .* deg"):
        cf.throws.FurtherPin(angle=120.0)


MOST = 400
# What a field may hold of which the usual text of a dataclass stays short.
SHORT = re.compile(r"(?:str|int|float|complex|bool|None|Literal|[|'\[\], ]|'[a-z -]+')+")
# Inputs that hold other inputs, and few of them.
NESTED = {
    "AxialSupport",
    "Coupling",
    "CrossheadEngine",
    "DrivenMachine",
    "EngineMagnifier",
    "Limit",
}
NESTED |= {"MainBearings", "ShaftCone", "TorsionalRing"}


@pytest.mark.slow
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
        if issubclass(one, BaseException) or hasattr(one, "_repr_html_"):
            continue
        assert dataclasses.is_dataclass(one), name
        kinds = (
            {} if name in NESTED else {own.name: str(own.type) for own in dataclasses.fields(one)}
        )
        for field, kind in kinds.items():
            kind = re.sub(r"<class '(.*)'>", r"\1", kind).replace("typing.", "")
            kind = re.sub(r"Annotated\[(\w+), Quantity\([^)]*\)\]", r"\1", kind)
            assert SHORT.fullmatch(kind), (name, field, kind)


def test_an_input_shows_what_was_given(dimensions):
    throw = cf.CrankThrow(**dimensions)
    assert eval(repr(throw), {"CrankThrow": cf.CrankThrow}) == throw
    assert "web_outline" not in repr(throw)
    assert "<th>pin_diameter</th><td>0.18 m</td>" in throw._repr_html_()
    assert len(repr(cf.Crankshaft([throw] * 9, crank_angles_deg=[0.0] * 9))) <= MOST


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
    assert not re.search(r"\bmodel_", page)  # Python 3.13 also lists what a metaclass made
    names = dir(cf.STEEL)
    assert {"changed", "density", "shear_modulus"} <= set(names)
    assert not [name for name in names if name.startswith("model_")]
    assert cf.STEEL.model_fields_set  # hidden, not gone


def test_a_path_is_no_longer_than_a_line(tmp_path):
    @summarized("path")
    class Found:
        path = Path("/" + "deep/" * 60)

    assert len(repr(Found())) < 100
