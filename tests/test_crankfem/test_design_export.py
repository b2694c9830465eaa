"""Designs for other solvers: a table, a mesh or a solid of each, and results that come back."""

import csv

import numpy as np
import pytest

from comparing import close
from crankfem.analyses.study import design_export
from geometry.shapes import element_volumes

STUDY = """
[throw]
crank_radius = "170 mm"
main_journal_diameter = "220 mm"
pin_diameter = "180 mm"
main_journal_length = "120 mm"
pin_length = "139 mm"
web_width = "285 mm"
web_thickness = "68 mm"
[study]
held_out = 1
[study.factors]
pin_length = ["120 mm", "158 mm"]
"""


@pytest.fixture
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "study.toml").write_text(STUDY, encoding="utf-8")
    return tmp_path / "designs"


def lines(path):
    with path.open(encoding="utf-8", newline="") as file:
        return list(csv.DictReader(file))


def write_lines(path, table):
    with path.open("w", encoding="utf-8", newline="") as file:
        writer = csv.DictWriter(file, list(table[0]))
        writer.writeheader()
        writer.writerows(table)


def masses_of_steel(files):
    """What another program makes of the meshes: of their curved tetrahedra."""
    meshio = pytest.importorskip("meshio")
    for file in files:
        mesh = meshio.read(file)
        elements = np.vstack([cells.data for cells in mesh.cells if cells.type == "tetra10"])
        yield 7850.0 * float(element_volumes(mesh.points, elements).sum())


@pytest.mark.further
def test_designs_go_out_and_results_of_another_program_come_back(call, folder):
    answer = call("doe", "study.toml", "--export", "designs", "--mesh", "inp")
    assert answer.code == 0, answer.err
    assert "3 designs, of which 3 have a file in the folder (3 written now)" in answer.out
    table = lines(folder / "designs.csv")
    assert [line["role"] for line in table] == ["run", "run", "held out"]
    assert [line["pin_length [m]"] for line in table[:2]] == ["0.12", "0.158"]
    masses = list(masses_of_steel(folder / line["file"] for line in table))
    # 38 mm of pin, and no more, make the difference.
    pin = 7850.0 * np.pi / 4.0 * 0.180**2 * 0.038
    assert masses[1] - masses[0] == close(pin, rel=2e-3)
    results = [line | {"mass [kg]": m} for line, m in zip(table, masses, strict=True)]
    write_lines(folder / "results.csv", results)
    taken = ("doe", "study.toml", "--import", "designs/results.csv", "--no-compute")
    answer = call(*taken, "--json")
    assert answer.code == 0, answer.err
    record = answer.json()
    assert (record["runs"], record["held_out"], record["computed_now"]) == (2, 1, 0)
    assert record["table"]["responses"]["mass"] == close(masses)
    (fitted,) = record["fits"]
    assert fitted == "mass"
    # A straight line through two runs.
    linear = next(f for f in record["fits"]["mass"]["forms"] if f["form"] == "linear")
    slope = (masses[1] - masses[0]) / 0.038
    assert linear["coefficients"]["pin_length"] == close(slope)
    assert "are not used" not in answer.err
    again = call(*taken)
    assert "0 finished designs and 0 further rows imported" in again.err
    model = call("fit", "runs.sqlite")
    assert model.code == 0
    assert call("lookup", "model.json", "pin_length=130mm").code == 0


@pytest.fixture
def quick(monkeypatch):
    """Files without a kernel, and a throw of 158 mm that cannot be meshed."""
    made = []

    def write(design, file):
        made.append(file.name)
        if design.inputs["throw"]["pin_length"] == 0.158:
            raise design_export.MeshError("mesh: no way of meshing succeeded.")
        with design_export.atomic_file(file, "solid") as part:
            part.write_text("solid", encoding="utf-8")

    monkeypatch.setattr(design_export, "_write", write)
    return made


def test_what_is_there_is_not_made_again(call, folder, quick):
    line = ("doe", "study.toml", "--export", "designs", "--mesh", "step")
    record = call(*line, "--json").json()
    assert record["written"] == 2
    (failed,) = record["failures"]
    assert record["failures"][failed] == "mesh: no way of meshing succeeded."
    assert record["files"][1] == failed
    quick.clear()
    answer = call(*line)
    assert len(quick) == 1  # the one that is missing
    assert "3 designs, of which 2 have a file in the folder (0 written now)" in answer.out
    assert f"Not written: {failed}: mesh: no way" in " ".join(answer.out.split())


@pytest.mark.parametrize("name", ["designs.csv", "mesh"])
def test_nothing_of_the_users_is_replaced(call, folder, quick, name):
    line = ("doe", "study.toml", "--export", "designs", "--mesh", "step")
    files = call(*line, "--json").json()["files"]
    mine = folder / "designs.csv" if name == "designs.csv" else folder.parent / files[0]
    (folder / ".crankfem-outputs.json").unlink()
    for file in folder.glob("0*"):
        file.unlink()
    mine.write_text("mine", encoding="utf-8")
    if name == "mesh":
        (folder / "designs.csv").unlink()
    quick.clear()
    answer = call(*line)
    assert answer.code == 2
    assert "is not replaced, because crankfem has not made it" in " ".join(answer.err.split())
    assert mine.read_text(encoding="utf-8") == "mine"
    assert quick == []
