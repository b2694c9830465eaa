"""Element sizes of a CAD part's throw, by the rules for throws given by dimensions."""

import math
from itertools import pairwise

from geometry.cad_faces import Round
from geometry.parts import Cylinder
from geometry.sizes import (
    FILLET_ROOT_PER_WEB,
    ROOT_PER_FILLET,
    ROOT_PER_WEB,
    SIZE_PER_BORE,
    SizePlan,
    SizeZone,
)
from geometry.solid import BORE, Zone


def planned_sizes(
    row: list[Round],
    reaches: list[tuple[float, float]],
    fillets: dict[Zone, list[int]],
    corners: dict[Zone, list[int]],
    radii: dict[Zone, float],
    holes: tuple[Cylinder, ...],
) -> SizePlan:
    """Choose element sizes by the rules for throws given by dimensions.

    A web is as thick as the gap between the journal or pin before it and the one after it.
    """
    thinnest_pin = min(pin.radius for pin in row[1:-1])
    gaps = [after[0] - before[1] for before, after in pairwise(reaches)]
    webs = [gap for gap in gaps if gap > 0.02 * thinnest_pin]
    thinnest = min(webs, default=thinnest_pin)
    bulk = min(thinnest, thinnest_pin)
    zones = []
    for zone in [*fillets, *corners]:
        number, end = zone
        gap = gaps[number - 1 if end == "start" else number]
        beside = gap if gap in webs else thinnest
        radius = row[number].radius
        sharp = zone not in fillets
        if sharp:
            size, area = ROOT_PER_WEB * beside, 0.0
        else:
            fillet = radii[zone]
            size = min(ROOT_PER_FILLET * fillet, FILLET_ROOT_PER_WEB * beside)
            area = math.pi * math.pi * fillet * (radius + 0.36 * fillet)
        zones.append(SizeZone(zone, sharp, min(bulk, size), 2.0 * math.pi * radius, area))
    for number, hole in enumerate(holes):
        length = 2.0 * math.pi * hole.bore_radius
        area = length * (hole.bore_end - hole.bore_start)
        size = min(bulk, SIZE_PER_BORE * hole.bore_radius)
        zones.append(SizeZone((number, BORE), False, size, length, area))
    return SizePlan(bulk, tuple(zones))
