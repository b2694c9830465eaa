"""Write random crankshafts as CAD programs do, read them back, and compare.

Run by hand: ``python tests/campaigns/cad_round_trip.py [COUNT] [FIRST SEED] [ANALYZED]`` (about ten
minutes for 100, of which 10 are analyzed); its figures are in docs/cad.md. The throws mix all features; the
shafts are turned by any rotation, shifted, some in inches, beside other parts, with divided faces. Each
must come back with its throws, angles, masses, kinds and symmetries, or be refused in one sentence.
"""

import math
import sys
import tempfile
import time
from collections import Counter
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).parents[1]))

from cad_files import Posture, write_shaft
from campaigns.random_throws import random_throw
from crankbase.errors import InputError, MeshError
from crankfem.satellites.cad.run import CadRun, run_cad
from fem.analysis import analyze_throw
from fem.material import STEEL
from geometry.crankshaft import Crankshaft, ShaftEnds, throw_masses


def random_shaft(seed: int) -> Crankshaft:
    """Draw a crankshaft of two to six throws of up to three kinds, one of them perhaps turned end for end.

    Raises
    ------
    InputError
        If the draw is one that cannot be built.
    """
    draw = np.random.default_rng(1000 + seed)
    first = random_throw(seed)
    kinds = [first, first.reversed()]
    thickness = first.web_thickness * draw.uniform(1.02, 1.2)
    kinds.append(first.changed(web_thickness=thickness))
    count = int(draw.integers(2, 7))
    throws = [kinds[int(draw.choice([0, 0, 0, 1, 2]))] for _ in range(count)]
    step = float(draw.choice([60.0, 72.0, 90.0, 120.0, 180.0]))
    angles = [0.0, *(step * int(draw.integers(0, 6)) for _ in throws[1:])]
    diameter = first.main_journal_diameter
    ends = ShaftEnds(
        free_end_diameter=0.8 * diameter,
        free_end_length=0.7 * diameter,
        flange_diameter=1.5 * diameter,
        flange_thickness=0.2 * diameter,
    )
    return Crankshaft(throws, crank_angles_deg=angles, ends=ends)


def random_posture(seed: int) -> Posture:
    """Draw how a crankshaft lies in its file."""
    draw = np.random.default_rng(2000 + seed)
    x, y, z = (float(part) for part in draw.normal(size=3))
    place = tuple(float(part) for part in 0.3 * draw.normal(size=3))
    return Posture(
        (x, y, z),
        place,
        unit=str(draw.choice(["mm", "inch"])),
        beside=bool(draw.random() < 0.4),
        divided=bool(draw.random() < 0.25),
    )


def differences(shaft: Crankshaft, run: CadRun) -> dict[str, float]:
    """Largest differences of a crankshaft read from what was written; infinite if throws are missing."""
    if len(run.throws) != len(shaft.throws):
        return {"throws": math.inf}
    wanted = np.array([throw_masses(throw, STEEL.density).mass for throw in shaft.throws])
    read = np.array([throw.mass for throw in run.throws])
    turn = np.array(shaft.crank_angles_deg) - [throw.angle_deg for throw in run.throws]
    starts = np.array([throw.start for throw in run.throws]) - shaft.starts[:-1]
    # A throw is told like the first one from which it is unchanged, else like the first of its kind.
    kinds = kinds_of(shaft)
    read_kinds = [kinds[throw.like - 1] for throw in run.throws]
    new = sum(throw.like == throw.number for throw in run.throws)
    return {
        "angle [deg]": float(np.abs((turn + 180.0) % 360.0 - 180.0).max()),
        "place [m]": float(np.abs(starts).max()),
        "mass": float(np.abs(read / wanted - 1.0).max()),
        "kinds": float(sum(map(int.__ne__, read_kinds, kinds)) + abs(new - len(set(kinds)))),
        "symmetries": float(
            sum(
                throw.symmetry != written.symmetry
                for throw, written in zip(run.throws, shaft.throws, strict=True)
            )
        ),
    }


def kinds_of(shaft: Crankshaft) -> list[int]:
    """Return the number of the first throw of each one's kind; those turned end for end are of one kind."""
    volumes = np.array([throw.volume for throw in shaft.throws])
    return [int(np.argmax(np.isclose(volumes, each, rtol=1e-9))) + 1 for each in volumes]


def compliance_differences(shaft: Crankshaft, run: CadRun) -> dict[str, float]:
    """Largest differences of compliances, relative to the sum of both error bars."""
    worst = {"axial / bars": 0.0, "torsional / bars": 0.0}
    for number, read in run.analyses.items():
        written = analyze_throw(shaft.throws[number - 1])
        bars, others = written.error_bars(), read.error_bars()
        axial = abs(read.axial_compliance() - written.axial_compliance())
        torsional = abs(read.torsional_compliance() - written.torsional_compliance())
        for name, off, both in (
            ("axial / bars", axial, bars.axial + others.axial),
            ("torsional / bars", torsional, bars.torsional + others.torsional),
        ):
            worst[name] = max(worst[name], off / both)
    return worst


def main(count: int = 100, first: int = 1, analyzed: int = 10) -> None:
    """Run the campaign and print its table."""
    outcomes: Counter[str] = Counter()
    worst: dict[str, float] = {}
    seconds = []
    with tempfile.TemporaryDirectory() as folder:
        for seed in range(first, first + count):
            try:
                shaft = random_shaft(seed)
                file = write_shaft(Path(folder) / "shaft.step", shaft, random_posture(seed))
            except (InputError, MeshError) as error:
                outcomes["not built"] += 1
                print(f"{seed}: not built: {error}", flush=True)
                continue
            begin = time.perf_counter()
            try:
                wanted = analyzed > outcomes["read"]
                run = run_cad(file, accuracy=0.01 if wanted else None)
            except (InputError, MeshError) as error:
                outcomes["refused"] += 1
                print(f"{seed}: refused: {error}", flush=True)
                continue
            seconds.append(time.perf_counter() - begin)
            off = differences(shaft, run)
            if wanted:
                off |= compliance_differences(shaft, run)
            outcomes["read"] += 1
            print(f"{seed}: {len(shaft.throws)} throws, {off}", flush=True)
            for name, value in off.items():
                worst[name] = max(value, worst.get(name, 0.0))
    print(f"{dict(outcomes)}; median {np.median(seconds):.1f} s, longest {max(seconds):.1f} s")
    for name, value in worst.items():
        print(f"{name}: {value:.3g} at most")


if __name__ == "__main__":
    main(*map(int, sys.argv[1:]))
