"""Free modes of crankshafts read from CAD, against CalculiX on the uncut solids of the same files.

Run by hand, with CalculiX (``ccx``): ``python tests/campaigns/cad_free_modes.py [NAME ...]``, each a shipped
engine or the seed of a random crankshaft; about ten minutes a crankshaft. Its figures are in docs/cad.md.
Nothing is cut or condensed in the reference: each solid is meshed twice, the second time with elements of 0.8
of the size, and its frequencies are extrapolated to none.
"""

import os
import re
import subprocess
import sys
import tempfile
import time
from dataclasses import replace
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).parents[2] / "benchmarks"))
sys.path.insert(0, str(Path(__file__).parents[1]))

from cad_files import write_shaft
from campaigns.cad_round_trip import random_posture, random_shaft
from crankbase.array_checks import Array
from crankfem.files.engine.throw_file import load_crankshaft
from crankfem.satellites.cad.free_shaft import free_modes
from crankfem.satellites.cad.run import end_analyses
from fem.material import STEEL
from geometry.gmsh_session import gmsh_session
from geometry.imported import read_part
from geometry.imported_shaft import import_crankshaft
from geometry.mesh import check_quality, check_volume, read_mesh, solid_properties
from geometry.shapes import straighten_elements
from shaft_solid import ShaftMesh, frequency_deck

# Of the first mesh: elements, and the smallest ones at fillets, beside the main journal's diameter; and
# elements round a full circle.
SIZE, SMALLEST, AROUND = 0.3, 0.045, 5.0
# Of the second mesh, of the first one's sizes; and the power of the size with which frequencies converged on
# a third one (3 to 4, by mode).
FINER, ORDER = 0.8, 3.5
SHAFTS = ("2ch85-110", "vw-tdi", "63")
MODES = 5


def solid_mesh(path: Path, diameter: float, scale: float) -> ShaftMesh:
    """Mesh the uncut solid of a file."""
    with gmsh_session("solid") as gmsh:
        read_part(gmsh, str(path))
        gmsh.model.occ.synchronize()
        solid = solid_properties(gmsh)
        for option, value in (
            ("MeshSizeMax", scale * SIZE * diameter),
            ("MeshSizeMin", scale * SMALLEST * diameter),
            ("MeshSizeFromCurvature", AROUND / scale),
            ("MeshSizeExtendFromBoundary", 1),
        ):
            gmsh.option.setNumber(f"Mesh.{option}", value)
        gmsh.model.mesh.generate(3)
        gmsh.model.mesh.setOrder(2)
        points, elements, _ = read_mesh(gmsh, {})
    points, _ = straighten_elements(points, elements)
    check_volume(points, elements, solid)
    check_quality(points, elements)
    return ShaftMesh(points, elements, np.zeros(0), diameter)


def calculix_frequencies(mesh: ShaftMesh, folder: Path) -> Array:
    """Frequencies of the first elastic modes by CalculiX [Hz]."""
    (folder / "shaft.inp").write_text(frequency_deck(mesh, STEEL, MODES + 6), encoding="utf-8")
    subprocess.run(
        ["ccx", "-i", "shaft"],
        cwd=folder,
        env=os.environ | {"OMP_NUM_THREADS": "1"},
        capture_output=True,
        check=True,
    )
    printed = (folder / "shaft.dat").read_text(encoding="utf-8")
    rows = re.findall(r"^ +(\d+) +\S+ +\S+ +(\S+) +\S+ *$", printed, re.M)
    return np.array([float(frequency) for _, frequency in rows])[6 : 6 + MODES]


def compare(name: str, folder: Path) -> float:
    """Compare one crankshaft, and return the largest difference."""
    path = folder / "crank.step"
    if name.isdecimal():
        posture = replace(random_posture(int(name)), beside=False)
        write_shaft(path, random_shaft(int(name)), posture)
    else:
        write_shaft(path, load_crankshaft(name))
    begin = time.process_time()
    shaft = import_crankshaft(path)
    modes = free_modes(shaft, end_analyses(shaft), MODES)
    seconds = time.process_time() - begin
    ours = modes.frequencies[modes.rigid : modes.rigid + MODES]
    diameter = min(journal.diameter for journal in shaft.journals)
    meshes = [solid_mesh(path, diameter, scale) for scale in (1.0, FINER)]
    first, second = (calculix_frequencies(mesh, folder) for mesh in meshes)
    limit = second - (first - second) / (FINER**-ORDER - 1.0)
    off = ours / limit - 1.0
    print(
        f"{name}: {len(shaft.throws)} throws, {seconds:.1f} s; {[mesh.unknowns for mesh in meshes]} unknowns"
    )
    for row in zip(ours, first, second, limit, 100.0 * off, strict=True):
        print("  " + "  ".join(f"{value:9.3f}" for value in row), flush=True)
    return float(np.abs(off).max())


def main(names: list[str]) -> None:
    """Compare crankshafts, and print a line for each mode: ours, two meshes, their limit, difference [%]."""
    worst = 0.0
    for name in names or SHAFTS:
        with tempfile.TemporaryDirectory() as folder:
            worst = max(worst, compare(name, Path(folder)))
    print(f"largest difference: {100.0 * worst:.2f} %")


if __name__ == "__main__":
    main(sys.argv[1:])
