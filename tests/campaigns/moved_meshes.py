"""Meshes moved over 200 random boxes of throws, their topology against gmsh, and answers of random studies.

Run by hand: ``python tests/campaigns/moved_meshes.py [meshes|topology|answers] [COUNT] [FIRST SEED]`` (about
20 minutes each on one core, answers an hour); figures are in docs/accuracy.md. A box is a random throw
(random_throws.py, seeds from 3000 on), of which 3 to 8 dimensions vary by 5 or 10 %.
"""

import sys
import time
from collections import Counter, defaultdict

import numpy as np
from random_throws import random_throw

from crankbase.errors import InputError, MeshError
from fem.moved_mesh import make_reference
from fem.responses import evaluate_throw
from geometry.boundary_motion import lengths_of
from geometry.mesh import built_solid, keep_solids
from geometry.mesher import mesh_here
from geometry.shapes import smallest_jacobians
from geometry.throw import CrankThrow
from geometry.throw_dimensions import changed_record
from geometry.topology import topology
from regression.plans.designs import DesignChoice
from regression.plans.factors import Factor
from regression.plans.plan import StudyPlan
from regression.records import MESHED, MOVED, Outcome
from regression.runs.moved_answers import scaled_answers

FIRST_SEED = 3000
# Throws of a box; those in smaller classes are not moved.
THROWS, FEWEST = 12, 3
TRUE_ACCURACY, NAME = 0.003, "axial_compliance_pinned"


def boxes(count, seed):
    """Random throws, each with a generator of random numbers and the dimensions that vary."""
    while count:
        try:
            throw = random_throw(seed)
        except InputError:
            seed += 1
            continue
        draw = np.random.default_rng(seed + 10**6)
        paths = sorted(path for path, value in lengths_of(throw).items() if value)
        number = min(len(paths), int(draw.integers(3, 9)))
        chosen = [str(path) for path in draw.choice(paths, number, replace=False)]
        yield seed, throw, draw, chosen
        seed, count = seed + 1, count - 1


def varied(throw, draw, paths, amount):
    """Throws of a box that can be built, each with its place in it."""
    sizes, made = lengths_of(throw), []
    for _ in range(THROWS):
        place = draw.uniform(-1.0, 1.0, len(paths))
        changes = {
            path: sizes[path] * (1.0 + amount * share)
            for path, share in zip(paths, place, strict=True)
        }
        try:
            made.append((place, CrankThrow(**changed_record(throw.model_dump(), changes))))
        except InputError:
            continue
    return made


def meshes(count, first, amount):
    """Move meshes in all boxes, and count how."""
    ways, times, reasons = Counter(), defaultdict(list), Counter()
    for seed, throw, draw, paths in boxes(count, first):
        classes = defaultdict(list)
        for place, other in varied(throw, draw, paths, amount):
            classes[topology(other)].append((place, other))
        for members in classes.values():
            if len(members) < FEWEST:
                ways["in smaller classes"] += len(members)
                continue
            places = np.array([place for place, _ in members])
            middle = np.linalg.norm(places - places.mean(axis=0), axis=1).argmin()
            try:
                reference = make_reference(members[int(middle)][1], paths, mesh_here)
            except MeshError as error:
                ways["no reference"] += len(members)
                reasons[f"{seed}: {error}"] += len(members)
                continue
            for number, (_, other) in enumerate(members):
                if number == middle:
                    continue
                begin = time.process_time()
                try:
                    moved = reference.at(other)
                except MeshError as error:
                    ways["not moved"] += 1
                    reasons[f"{seed}: {error}"] += 1
                else:
                    ways[moved.tier] += 1
                    mesh = moved.mesh
                    assert smallest_jacobians(mesh.points, mesh.elements).min() > 0.0, seed
                times[reference.mesh.part].append(1e3 * (time.process_time() - begin))
    tried = sum(ways.values()) - ways["in smaller classes"]
    lost = ways["not moved"] + ways["no reference"]
    print(f"+-{100 * amount:g} %: {dict(ways)}, moved {100 * (1 - lost / tried):.1f} %")
    print({part: f"{np.median(ms):.1f} ms" for part, ms in times.items()})
    for reason, number in reasons.most_common():
        print(number, reason)


def topologies(count, first):
    """Compare topologies with the numbers of faces, edges and corners of the solid."""
    known, tried = defaultdict(set), 0
    for seed, throw, draw, paths in boxes(count, first):
        for amount in (0.05, 0.1):
            for _, other in varied(throw, draw, paths, amount):
                if tried == count:
                    break
                try:
                    with built_solid(other.parts, other.symmetry) as built:
                        entities = built.gmsh.model.getEntities
                        found = tuple(len(entities(dimension)) for dimension in (2, 1, 0))
                except MeshError:
                    continue
                known[seed, topology(other)].add(found)
                tried += 1
    mixed = sum(len(found) > 1 for found in known.values())
    print(f"{tried} throws of {len(known)} topologies, of which {mixed} have several solids")


def solved(key, inputs, reference):
    """Outcome of a design, on a moved mesh if there is a reference."""
    throw = CrankThrow(**inputs["throw"])
    found = evaluate_throw(
        throw, accuracy=inputs["accuracy"], mesher=mesh_here, reference=reference
    )
    mesh = {"tier": found.moved.tier if found.moved else MESHED} if reference else {}
    return Outcome(key, inputs, found.values, None, 0.0, errors=found.errors, mesh=mesh)


def answers(count, first):
    """Scaled answers of random studies against finer ones, and what anchors left out show of their ratio."""
    within, tried, scatters = 0, 0, []
    for seed, throw, _, paths in boxes(10**6, first):
        sizes = lengths_of(throw)
        factors = tuple(
            Factor(
                path,
                "rad" if "angle" in path else "m",
                *sorted((0.95 * sizes[path], 1.05 * sizes[path])),
            )
            for path in paths[:5]
        )
        try:
            design = DesignChoice("latin hypercube", runs=4 * len(factors))
            planned = StudyPlan(throw, factors, design, held_out=5, mesh="moved").planned
        except InputError:
            continue
        if len({design.mesh_class for design in planned.designs}) > 1:
            continue
        references, outcomes = {}, {}
        judged = planned.designs[-2:]
        for one in planned.designs:
            if one.mesh_class is None or not (one.ordinary or one in judged):
                continue
            name = one.mesh_class
            if name not in references:
                moved = one.inputs[MOVED]
                references[name] = make_reference(
                    CrankThrow(**moved["throw"]), moved["paths"], mesh_here
                )
            outcomes[one.key] = solved(one.key, one.inputs, references[name])
            if one.ordinary:
                outcomes[one.ordinary[0]] = solved(*one.ordinary, None)
        scaled = scaled_answers(planned.designs, outcomes)
        scatters += [fits[NAME].scatter for fits in scaled.fits.values() if fits]
        for one in judged:
            if one.key not in scaled.outcomes:
                continue
            true = solved("", one.inputs | {"accuracy": TRUE_ACCURACY}, None).responses
            found = scaled.outcomes[one.key]
            off = abs(found.responses[NAME] / true[NAME] - 1.0)
            within += off < found.errors[NAME]
            tried += 1
            print(f"{seed}: {100 * off:.2f} % of {100 * found.errors[NAME]:.2f} %", flush=True)
        if tried >= count:
            break
    known = [100 * scatter for scatter in scatters if scatter is not None]
    print(
        f"{within} of {tried} within their bars; scatter of ratios in %: {np.sort(known).round(3)}"
    )


def main(what="meshes", count="200", first=FIRST_SEED):
    keep_solids()
    which = int(count), int(first)
    if what == "topology":
        topologies(*which)
    elif what == "answers":
        answers(*which)
    else:
        for amount in (0.05, 0.1):
            meshes(*which, amount)


if __name__ == "__main__":
    main(*sys.argv[1:])
