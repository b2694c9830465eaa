import pkgutil
import sys

import pytest

import crankfem as cf

HEAVY = (
    *("gmsh", "vtk", "vtkmodules", "pyvista", "matplotlib", "skfem", "pypardiso", "meshio"),
    *("pandas", "xarray", "plotly"),
)


def test_every_public_name_is_there_once():
    assert [name for name in cf.__all__ if getattr(cf, name, None) is None] == []
    assert len(set(cf.__all__)) == len(cf.__all__)
    assert set(cf.__all__) <= set(dir(cf))


def test_no_module_of_the_package_takes_a_public_name():
    """Importing a submodule would put it in the place of the name."""
    modules = {found.name for found in pkgutil.iter_modules(cf.__path__)}
    assert not modules & set(cf.__all__)


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


def test_an_unknown_name():
    with pytest.raises(AttributeError, match="module 'crankfem' has no attribute 'magic'"):
        cf.magic  # noqa: B018


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
