"""Element sizes of a CAD part's throw, by the rules for throws given by dimensions."""

from itertools import pairwise

from geometry.cad_faces import Round
from geometry.parts import Cylinder
from geometry.sizes import SIZE_PER_BORE, SizePlan, bore_zone, root_size, root_zone
from geometry.solid import Zone


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
        fillet = radii[zone] if zone in fillets else 0.0
        size = root_size(fillet, gap if gap in webs else thinnest)
        zones.append(root_zone(zone, row[number].radius, fillet, min(bulk, size)))
    for number, hole in enumerate(holes):
        zones.append(bore_zone(number, hole, min(bulk, SIZE_PER_BORE * hole.bore_radius)))
    return SizePlan(bulk, tuple(zones))
