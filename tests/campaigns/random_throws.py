"""Mesh 300 random throws that mix all features, each in the isolated process.

Run by hand: ``python tests/campaigns/random_throws.py [COUNT] [FIRST SEED]`` (about five minutes for
300); its figures are in docs/throws.md. Every throw must give a mesh that passes the checks, or
one sentence why not before meshing; the process must not crash or hang.
"""

import math
import sys
import time
from collections import Counter
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).parents[1]))

from condensed_parts import mass_of_elements
from crankbase.errors import InputError, MeshError
from geometry.mass import mass_properties
from geometry.mesher import mesh_isolated
from geometry.shapes import corner_quality, smallest_jacobians
from geometry.sizes import predict_unknowns
from geometry.throw import CrankThrow
from geometry.throw_dimensions import Counterweight, FurtherPin, Web

Random = np.random.Generator


def random_throw(seed: int) -> CrankThrow:
    """Draw a throw; dimensions keep to the proportions of real cranks, features come and go.

    Raises
    ------
    InputError
        If the draw is one that cannot be built.
    """
    draw = np.random.default_rng(seed)
    pin = 0.04 * float(np.exp(draw.uniform(0.0, math.log(20.0))))  # 40 to 800 mm
    journal = pin * draw.uniform(0.9, 1.35)
    values: dict[str, object] = {
        "pin_diameter": pin,
        "main_journal_diameter": journal,
        "crank_radius": pin * draw.uniform(0.65, 1.4),
        "main_journal_length": pin * draw.uniform(0.45, 1.1),
        "pin_length": pin * draw.uniform(0.45, 1.1),
        "web_thickness": pin * draw.uniform(0.25, 0.6),
        "web_width": max(pin, journal) * draw.uniform(1.25, 1.8),
    }
    values |= _fillets(draw, pin, journal)
    values |= _outline(draw, values)
    values |= _bores(draw, values)
    values |= _webs(draw, values)
    values |= _counterweights(draw, values)
    values |= _further_pins(draw, values)
    return CrankThrow(**values)


def _chance(draw: Random, share: float) -> bool:
    return bool(draw.random() < share)


def _fillets(draw: Random, pin: float, journal: float) -> dict[str, object]:
    if _chance(draw, 0.2):
        return {}
    if _chance(draw, 0.5):
        return {"fillet_radius": min(pin, journal) * draw.uniform(0.02, 0.09)}
    return {
        "main_journal_fillet_radius": journal * draw.uniform(0.02, 0.09) * _chance(draw, 0.8),
        "pin_fillet_radius": pin * draw.uniform(0.02, 0.09) * _chance(draw, 0.8),
    }


def _outline(draw: Random, values: dict[str, object]) -> dict[str, object]:
    width, seat = values["web_width"], _seats(values)
    made: dict[str, object] = {}
    rectangle = _chance(draw, 0.45)
    if rectangle or _chance(draw, 0.5):
        for name, radius in zip(("web_journal_end", "web_pin_end"), seat, strict=True):
            made[name] = max(1.05 * radius, width * draw.uniform(0.42, 0.65))
        if not rectangle:
            largest = max(made, key=lambda name: made[name])
            made[largest] = max(made[largest], width * draw.uniform(0.5, 0.65))
            # A web whose ends differ by more than its length is no web.
            other = next(name for name in made if name != largest)
            made[other] = max(made[other], made[largest] - 0.5 * values["crank_radius"])
    if rectangle:
        made["web_outline"] = "rectangle"
        # The corner must stay clear of the fillets.
        room = min(
            made[name] + width / 2.0 - 1.45 * radius
            for name, radius in zip(made, seat, strict=False)
        )
        corner = min(room, width * draw.uniform(0.03, 0.3))
        kind = draw.choice(["web_corner_radius", "web_corner_chamfer", ""])
        if kind and corner > 0.02 * width:
            made[str(kind)] = corner
    return made


def _seats(values: dict[str, object]) -> tuple[float, float]:
    """Radii of journal and pin with their fillets."""
    common = values.get("fillet_radius", 0.0)
    return (
        values["main_journal_diameter"] / 2.0 + values.get("main_journal_fillet_radius", common),
        values["pin_diameter"] / 2.0 + values.get("pin_fillet_radius", common),
    )


def _bores(draw: Random, values: dict[str, object]) -> dict[str, object]:
    made: dict[str, object] = {}
    for name in ("main_journal", "pin"):
        if _chance(draw, 0.4):
            diameter = values[f"{name}_diameter"]
            made[f"{name}_bore"] = diameter * draw.uniform(0.1, 0.5)
            if _chance(draw, 0.3):
                made[f"{name}_bore_offset"] = diameter * draw.uniform(-0.1, 0.15)
    if len([name for name in made if name.endswith("bore")]) == 2:
        free = values["crank_radius"] - 0.1 * values["pin_diameter"]
        free += made.get("pin_bore_offset", 0.0) - made.get("main_journal_bore_offset", 0.0)
        share = min(1.0, 2.0 * free / (made["main_journal_bore"] + made["pin_bore"]))
        made["main_journal_bore"] *= share
        made["pin_bore"] *= share
    return made


def _webs(draw: Random, values: dict[str, object]) -> dict[str, object]:
    made: dict[str, object] = {}
    thickness = values["web_thickness"]
    journal_seat, pin_seat = _seats(values)
    radius = values["crank_radius"]
    tip = radius + values.get("web_pin_end", values["web_width"] / 2.0)
    foot = values.get("web_journal_end", values["web_width"] / 2.0)
    if _chance(draw, 0.3) and tip - 1.05 * journal_seat > 0.1 * values["web_width"]:
        made["web_tip_thickness"] = thickness * draw.uniform(0.5, 0.95)
    if _chance(draw, 0.2) and foot + radius - 1.05 * pin_seat > 0.1 * values["web_width"]:
        made["web_foot_thickness"] = thickness * draw.uniform(0.5, 0.95)
    if _chance(draw, 0.35):
        made["right_web"] = Web(thickness=thickness * draw.uniform(1.0, 1.5))
    return made


def _counterweights(draw: Random, values: dict[str, object]) -> dict[str, object]:
    if not _chance(draw, 0.45):
        return {}
    foot = values.get("web_journal_end", values["web_width"] / 2.0)
    corner = 1.45 if values.get("web_outline") == "rectangle" else 1.1
    weight: dict[str, float] = {
        "outer_radius": foot * draw.uniform(corner, 1.9),
        "angle": math.radians(draw.uniform(50.0, 180.0)),
    }
    if _chance(draw, 0.4):
        weight["inner_radius"] = foot * draw.uniform(0.3, 0.8)
    if _chance(draw, 0.5):
        share = draw.uniform(0.5, 0.95)
        weight["thickness"] = values["web_thickness"] * share
        thinned = values.get("web_foot_thickness", values["web_thickness"])
        free = min(0.3 * values["web_thickness"] * (1.0 - share), 0.3 * thinned)
        weight["offset"] = -free * draw.uniform(0.2, 1.0)
    made = Counterweight(**weight)
    if _chance(draw, 0.7):
        return {"counterweight": made}
    return {"left_web": Web(counterweight=made)}


def _further_pins(draw: Random, values: dict[str, object]) -> dict[str, object]:
    if not _chance(draw, 0.25):
        return {}
    seat = _seats(values)[1]
    width = max(values["web_width"], 2.1 * seat)
    kind = draw.choice(["bearing missing", "split", "split with web"])
    if kind == "bearing missing":
        angle = float(draw.choice([180.0, 180.0, 120.0, 90.0, 240.0]))
        return {"further_pins": (FurtherPin(angle=math.radians(angle), web_width=width),)}
    # The halves must overlap, and bores would meet where they do.
    largest = 2.0 * math.asin(min(0.9, 0.32 * values["pin_diameter"] / values["crank_radius"]))
    angle = min(math.radians(draw.uniform(10.0, 40.0)), largest)
    bores = dict.fromkeys(("pin_bore", "pin_bore_offset"), 0.0)
    if kind == "split":
        return {"further_pins": (FurtherPin(angle=angle, web_thickness=0.0),)} | bores
    thickness = values["pin_diameter"] * draw.uniform(0.1, 0.2)
    thickness = max(thickness, 0.05 * values["crank_radius"])
    pin = FurtherPin(angle=angle, web_thickness=thickness, web_width=width)
    return {"further_pins": (pin,)} | bores


def main(count: int = 300, first: int = 1) -> None:
    """Run the campaign and print its table."""
    found: Counter[str] = Counter()
    reasons: Counter[str] = Counter()
    seconds, ratios, masses, attempts = [], [], [], Counter()
    worst, flattest = 1.0, []
    begin = time.perf_counter()
    for seed in range(first, first + count):
        try:
            throw = random_throw(seed)
        except InputError as error:
            found["refused"] += 1
            reasons[str(error)] += 1
            print(f"{seed}: refused: {error}", flush=True)
            continue
        start = time.perf_counter()
        try:
            mesh = mesh_isolated(throw)
        except (InputError, MeshError) as error:
            found["failed"] += 1
            print(f"{seed}: FAILED: {error}", flush=True)
            continue
        seconds.append(time.perf_counter() - start)
        found[mesh.part] += 1
        found["meshed"] += 1
        ratios.append(predict_unknowns(throw.parts, mesh.size_factor, mesh.part) / mesh.unknowns)
        solid, elements = mass_properties(mesh, 7850.0), mass_of_elements(mesh, 7850.0)
        masses.append(abs(elements.mass / solid.mass - 1.0))
        worst = min(worst, float(smallest_jacobians(mesh.points, mesh.elements).min()))
        flattest.append(float(corner_quality(mesh.points, mesh.elements).min()))
        attempts[len(mesh.attempts)] += 1
        found["with mended elements"] += mesh.mended_elements > 0
        for attempt in mesh.attempts:
            print(f"{seed}: {attempt}", flush=True)
    print(f"{count} throws from seed {first} in {time.perf_counter() - begin:.0f} s")
    for name, number in found.items():
        print(f"{name:24s} {number:5d}  {100.0 * number / count:5.1f} %")
    print(f"tried again, by number of ways that failed: {dict(sorted(attempts.items()))}")
    print(f"seconds per mesh: median {np.median(seconds):.2f}, largest {max(seconds):.2f}")
    low, middle, high = np.percentile(ratios, [5, 50, 95])
    print(f"predicted / actual unknowns: 5 % {low:.2f}, median {middle:.2f}, 95 % {high:.2f}")
    print(f"mesh volume off the solid's: median {np.median(masses):.1e}, largest {max(masses):.1e}")
    print(
        f"flattest element, mean ratio: median {np.median(flattest):.2f}, least {min(flattest):.1e}"
    )
    print(f"smallest Jacobian beside the element's mean: {worst:.2f}")


if __name__ == "__main__":
    main(*(int(text) for text in sys.argv[1:3]))
