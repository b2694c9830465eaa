import doctest
import importlib
import inspect
import pkgutil
import sys
from collections import Counter
from pathlib import Path

import pytest

import crankfem as cf

HEAVY = (
    *("gmsh", "vtk", "vtkmodules", "pyvista", "matplotlib", "skfem", "pypardiso", "meshio"),
    *("pandas", "xarray", "plotly"),
)


TOPICS = {name: one for name in cf.__all__ if inspect.ismodule(one := getattr(cf, name))}


@pytest.mark.parametrize("package", [cf, *TOPICS.values()], ids=lambda one: one.__name__)
def test_every_public_name_is_there(package):
    assert len(set(package.__all__)) == len(package.__all__)
    for name in package.__all__:
        assert getattr(package, name) is not None
        assert name in dir(package)


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


def test_all_ways_to_a_name_of_a_topic(spawn):
    code = (
        "from crankfem.chains import with_damper; from crankfem import chains; import crankfem as cf; "
        "assert cf.chains is chains and cf.chains.with_damper is with_damper is chains.with_damper"
    )
    answer = python(spawn, code)
    assert answer.code == 0, answer.err


def test_the_promised_names():
    promised = {
        "CrankThrow",
        "STEEL",
        "Material",
        "analyze_throw",
        "Neighbors",
        "axial_formulas",
        "torsional_formulas",
        "run_study",
        "run_engine",
        "ComplianceModel",
        "Chain",
        "harmonics",
        "mesh_throw",
        "engine_vibration",
        "InputError",
    }
    assert promised <= set(cf.__all__)


@pytest.mark.parametrize("module", [cf, cf.chains])
def test_only_public_names_are_listed(module):
    assert [name for name in dir(module) if not name.startswith("__")] == module.__all__


def test_an_unknown_name():
    with pytest.raises(AttributeError, match="module 'crankfem' has no attribute 'magic'"):
        cf.magic  # noqa: B018
    with pytest.raises(AttributeError, match=r"module 'crankfem\.chains' has no attribute 'magic'"):
        cf.chains.magic  # noqa: B018


def python(spawn, code, **options):
    return spawn("-c", code, command=[sys.executable, "-P"], **options)


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
