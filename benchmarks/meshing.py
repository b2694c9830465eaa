"""Processor time to build and mesh a throw in the mesher's process: quarter, half and full model.

Run by hand: ``python benchmarks/meshing.py``; its figures are in docs/throws.md. At size factor 1
the axial compliance of this throw is about 1 % below the converged value. The second mesh of a throw
takes the solid that the process has kept of the first.
"""

import numpy as np

import crankfem as cf
from geometry.gmsh_session import IsolatedProcess
from geometry.mesh import PARTS
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


def spent(process):
    """Processor time that a process has spent so far [s]."""
    return process.call("time:process_time", time_limit=10.0)


def main():
    throw = cf.CrankThrow(**THROW)
    other = throw.changed(crank_radius=0.180)
    process = IsolatedProcess()
    mesh_isolated(other, 2.0, process=process)  # imports what it needs
    print("factor  part     unknowns  first mesh [s]  second mesh [s]")
    for factor in (2.0, 1.0):
        for part in PARTS:
            taken = []
            for _ in range(REPEATS):
                mesh_isolated(other, 3.0, part, process=process)
                before = spent(process)
                mesh = mesh_isolated(throw, factor, part, process=process)
                between = spent(process)
                mesh_isolated(throw, factor, part, process=process)
                taken.append((between - before, spent(process) - between))
            first, second = np.median(taken, axis=0)
            print(f"{factor:6.1f}  {part:8s} {mesh.unknowns:8d}  {first:14.3f}  {second:15.3f}")
    process.close()


if __name__ == "__main__":
    main()
