"""A schematic of the engine: cylinders and cranks, flywheel, damper and line along the shaft, and a star."""

import math
from collections.abc import Sequence

from markupsafe import Markup, escape

from crankfem.analyses.vibration.modes import Vibration
from crankfem.files.engine.mechanism_cylinders import order_named

# Lengths of the drawing, without a unit.
STEP, SHAFT, HEIGHT, STAR = 46.0, 118.0, 190.0, 170.0
LEAST_DISC, LARGEST_DISC, THROW = 9.0, 44.0, 26.0
PISTON, APART = 24.0, 11.0
LINE, FILL, ACCENT = "#1d2733", "#e9f1f8", "#1f5f99"


def engine_schematic(
    angles: Sequence[float],
    firing_order: Sequence[int],
    chain: Vibration,
    driven_by: str | None = None,
) -> Markup:
    """Draw the engine as its torsional chain has it, from the free end, and the star of its cranks.

    Parameters
    ----------
    angles : sequence of float
        Of its cranks [rad].
    chain : Vibration
        The points of its torsional chain with their inertias.
    driven_by : str, optional
        What turns it, if it takes power.

    Returns
    -------
    Markup
        An SVG element.
    """
    names = chain.nodes
    # Those that ride on the free end.
    rings = {name for name in names if "ring" in name.split() or "damper" in name}
    places, along = [], -1
    for name in names:
        along += name not in rings
        places.append(0 if name in rings else along)
    width = STEP * (max(places) + 1.5)
    largest = float(max(chain.inertia)) or 1.0
    drawn = [_line(STEP, SHAFT, width - STEP / 2.0, SHAFT, 4.0)]
    inertias = zip(names, chain.inertia.tolist(), strict=True)
    around = max(
        (_ring_radius(inertia, largest) for name, inertia in inertias if name in rings), default=0.0
    )
    crank, named_place, named_at = 0, -2, 0.0
    for name, place, inertia in zip(names, places, chain.inertia.tolist(), strict=True):
        x = STEP * (place + 1.0)
        if name in rings:
            drawn.append(_disc(x, _ring_radius(inertia, largest), dashed=True))
            drawn.append(_label(x, SHAFT - _ring_radius(inertia, largest) - 5.0, name))
        elif name.startswith(("cylinder ", "throw ", "crank ")) and crank < len(angles):
            drawn.append(_crank(x, angles[crank], name.rpartition(" ")[2]))
            crank += 1
        elif inertia > 0.0:
            radius = _radius(inertia, largest)
            drawn.append(_disc(x, radius))
            # Close below its disc or the ring about it, and apart from the name of a disc beside it.
            below = SHAFT + max(radius, 0.0 if place else around) + 12.0
            if place - named_place == 1 and abs(below - named_at) < APART:
                below = named_at + APART
            named_place, named_at = place, below
            drawn.append(_label(x, below, name))
    total = width + STAR
    order = "-".join(map(str, firing_order))
    what = "machine" if driven_by else "engine"
    label = f"The {what} along its shaft: {', '.join(names)}; {order_named(driven_by)} {order}"
    return Markup(
        '<svg viewBox="0 0 {} {}" role="img" aria-label="{}" '
        'font-family="sans-serif" font-size="10">{}{}</svg>'
    ).format(
        f"{total:.0f}",
        f"{HEIGHT:.0f}",
        label,
        Markup("").join(drawn),
        _star(width + STAR / 2.0, angles),
    )


def _radius(inertia: float, largest: float) -> float:
    """Of a disc of equal width, whose inertia grows with the fourth power of its radius."""
    return max(LEAST_DISC, LARGEST_DISC * math.sqrt(math.sqrt(inertia / largest)))


def _ring_radius(inertia: float, largest: float) -> float:
    """Of a damper's ring, drawn about the disc that it rides on."""
    return _radius(inertia, largest) + 5.0


def _line(x: float, y: float, to_x: float, to_y: float, width: float, color: str = LINE) -> Markup:
    return Markup('<path d="M{} {}L{} {}" stroke="{}" stroke-width="{}" fill="none"/>').format(
        *(f"{length:.1f}" for length in (x, y, to_x, to_y)), color, f"{width:g}"
    )


def _disc(x: float, radius: float, *, dashed: bool = False) -> Markup:
    return Markup('<rect x="{}" y="{}" width="{}" height="{}" fill="{}" stroke="{}"{}/>').format(
        f"{x - (9.0 if dashed else 6.0):.1f}",
        f"{SHAFT - radius:.1f}",
        18 if dashed else 12,
        f"{2.0 * radius:.1f}",
        "none" if dashed else FILL,
        LINE,
        Markup(' stroke-dasharray="4 2"') if dashed else "",
    )


def _label(x: float, y: float, text: str) -> Markup:
    return Markup('<text x="{}" y="{}" text-anchor="middle" fill="{}">{}</text>').format(
        f"{x:.1f}", f"{y:.1f}", LINE, escape(text)
    )


def _crank(x: float, angle: float, number: str) -> Markup:
    """Draw a throw where its crank stands, with rod and piston above."""
    pin, top = SHAFT - THROW * math.cos(angle), SHAFT - 2.2 * THROW - THROW * math.cos(angle) * 0.5
    web = STEP * 0.2
    return Markup("").join(
        (
            _line(x - 1.6 * web, SHAFT, x + 1.6 * web, SHAFT, 5.0, "#ffffff"),
            _line(x - 1.6 * web, SHAFT, x - web, SHAFT, 4.0),
            _line(x + web, SHAFT, x + 1.6 * web, SHAFT, 4.0),
            _line(x - web, SHAFT, x - web, pin, 4.0),
            _line(x + web, SHAFT, x + web, pin, 4.0),
            _line(x - web, pin, x + web, pin, 4.0),
            _line(x, pin, x, top, 2.0, ACCENT),
            Markup('<rect x="{}" y="{}" width="{}" height="16" fill="{}" stroke="{}"/>').format(
                f"{x - PISTON / 2.0:.1f}", f"{top - 16.0:.1f}", PISTON, FILL, LINE
            ),
            _label(x, top - 4.0, number),
        )
    )


def _star(x: float, angles: Sequence[float]) -> Markup:
    """Draw the cranks as seen from the free end; cranks that stand alike share an arm."""
    y, arm = SHAFT - 22.0, 46.0
    arms: dict[int, list[int]] = {}
    for number, angle in enumerate(angles, start=1):
        arms.setdefault(round(math.degrees(angle)) % 360, []).append(number)
    drawn = [
        Markup('<circle cx="{}" cy="{}" r="5" fill="{}" stroke="{}"/>').format(
            f"{x:.1f}", f"{y:.1f}", FILL, LINE
        )
    ]
    for degrees, numbers in arms.items():
        across, up = math.sin(math.radians(degrees)), math.cos(math.radians(degrees))
        drawn.append(_line(x, y, x + arm * across, y - arm * up, 2.0, ACCENT))
        named = ", ".join(map(str, numbers))
        drawn.append(_label(x + (arm + 20.0) * across, y - (arm + 10.0) * up + 4.0, named))
    return Markup("").join(drawn)
