"""Time to build and mesh a throw, gmsh already imported: quarter, half and full model.

Run by hand: ``python benchmarks/meshing.py``; its figures stand in docs/throws.md. At size factor 1
the axial compliance of this throw is about 1 % below the converged value.
"""

import time

import numpy as np

import crankfem as cf
from geometry.mesh import PARTS, mesh_throw
from geometry.mesher import mesh_isolated

THROW = {
    "crank_radius": 0.170,
    "main_journal_diameter": 0.220,
    "pin_diameter": 0.180,
    "main_journal_length": 0.120,
    "pin_length": 0.139,
    "web_width": 0.300,
    "web_thickness": 0.068,
    "fillet_radius": 0.012,
}
REPEATS = 7


def seconds(mesh, throw, part):
    begin = time.perf_counter()
    made = mesh(throw, 1.0, part)
    return time.perf_counter() - begin, made.unknowns


def main():
    throw = cf.CrankThrow(**THROW)
    print("part     unknowns  here [s]  in a process of its own [s]")
    for mesh in (mesh_throw, mesh_isolated):
        mesh(throw, 2.0)  # imports gmsh, starts the process
    for part in PARTS:
        here, apart = [], []
        for _ in range(REPEATS):
            taken, unknowns = seconds(mesh_throw, throw, part)
            here.append(taken)
            apart.append(seconds(mesh_isolated, throw, part)[0])
        print(f"{part:8s} {unknowns:8d}  {np.median(here):8.2f}  {np.median(apart):8.2f}")


if __name__ == "__main__":
    main()
