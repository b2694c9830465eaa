"""Draw the pictures of docs/theory: plain SVG, no library but the standard one; takes no time."""

import math
from itertools import pairwise
from pathlib import Path

THEORY = Path(__file__).parent / "theory"
INK, SHADE, EDGE = "#22303c", "#e3e9ef", "#5a6672"
BLUE, RED, GREEN, ORANGE = "#1f5f99", "#b63b3b", "#2f7a4d", "#b5651d"
Point = tuple[float, float]


class Sheet:
    """An SVG that grows by shapes; coordinates in pixels, y downwards."""

    def __init__(self, width: float, height: float, title: str) -> None:
        self.width, self.height, self.title = width, height, title
        self.shapes: list[str] = []

    def line(
        self, points: list[Point], color: str = INK, width: float = 1.4, dash: str = ""
    ) -> None:
        """Draw a polyline."""
        dashed = f' stroke-dasharray="{dash}"' if dash else ""
        places = " ".join(f"{x:.1f},{y:.1f}" for x, y in points)
        self.shapes.append(
            f'<polyline points="{places}" fill="none" stroke="{color}" stroke-width="{width}" '
            f'stroke-linejoin="round"{dashed}/>'
        )

    def shape(self, points: list[Point], fill: str = SHADE, color: str = INK) -> None:
        """Draw a filled polygon."""
        places = " ".join(f"{x:.1f},{y:.1f}" for x, y in points)
        self.shapes.append(
            f'<polygon points="{places}" fill="{fill}" stroke="{color}" stroke-width="1.4" '
            'stroke-linejoin="round"/>'
        )

    def box(self, x: float, y: float, width: float, height: float, fill: str = SHADE) -> None:
        """Draw a rectangle by its upper left corner."""
        self.shape([(x, y), (x + width, y), (x + width, y + height), (x, y + height)], fill)

    def circle(self, place: Point, radius: float, fill: str = SHADE, color: str = INK) -> None:
        """Draw a circle."""
        self.shapes.append(
            f'<circle cx="{place[0]:.1f}" cy="{place[1]:.1f}" r="{radius:.1f}" fill="{fill}" '
            f'stroke="{color}" stroke-width="1.4"/>'
        )

    def arrow(self, start: Point, end: Point, color: str = RED, width: float = 2.2) -> None:
        """Draw an arrow with a slim head."""
        x, y = end[0] - start[0], end[1] - start[1]
        length = math.hypot(x, y)
        x, y, head = x / length, y / length, 4.0 + 2.2 * width
        root = (end[0] - head * x, end[1] - head * y)
        self.line([start, root], color, width)
        half = 0.36 * head
        self.shapes.append(
            f'<polygon points="{end[0]:.1f},{end[1]:.1f} {root[0] - half * y:.1f},{root[1] + half * x:.1f} '
            f'{root[0] + half * y:.1f},{root[1] - half * x:.1f}" fill="{color}"/>'
        )

    def dimension(self, start: Point, end: Point, label: str, shift: Point = (0.0, -6.0)) -> None:
        """Draw a thin line with a head at either end, and a label at its middle."""
        middle = (0.5 * (start[0] + end[0]), 0.5 * (start[1] + end[1]))
        self.arrow(middle, end, EDGE, 0.9)
        self.arrow(middle, start, EDGE, 0.9)
        self.text((middle[0] + shift[0], middle[1] + shift[1]), label, EDGE, 14)

    def arc(
        self, center: Point, radius: float, start: float, end: float, color: str = EDGE
    ) -> None:
        """Draw an arc between angles [deg] that count clockwise from upwards."""
        angles = [math.radians(start + (end - start) * step / 24) for step in range(25)]
        self.line(
            [(center[0] + radius * math.sin(a), center[1] - radius * math.cos(a)) for a in angles],
            color,
            1.1,
        )

    def spring(self, start: Point, end: Point, color: str = INK, turns: int = 5) -> None:
        """Draw a spring between two points of one height."""
        lead = 0.16 * (end[0] - start[0])
        step = (end[0] - start[0] - 2 * lead) / (2 * turns)
        points = [start, (start[0] + lead, start[1])]
        points += [
            (start[0] + lead + (place + 0.5) * step, start[1] + (-7 if place % 2 else 7))
            for place in range(2 * turns)
        ]
        self.line([*points, (end[0] - lead, end[1]), end], color, 1.3)

    def text(
        self, place: Point, label: str, color: str = INK, size: float = 16, anchor: str = "middle"
    ) -> None:
        """Write a label; _ begins a subscript that ends at a blank, words after ! stand upright."""
        upright = label.startswith("!")
        style = "" if upright else ' font-style="italic"'
        parts, first = [], True
        for word in label.removeprefix("!").split(" "):
            base, _, below = word.partition("_")
            blank = "" if first else " "
            parts.append(f"{blank}{base}")
            if below:
                parts.append(
                    f'<tspan font-size="{0.7 * size:.1f}" dy="{0.25 * size:.1f}">{below}</tspan>'
                    f'<tspan dy="{-0.25 * size:.1f}">&#8203;</tspan>'
                )
            first = False
        self.shapes.append(
            f'<text x="{place[0]:.1f}" y="{place[1]:.1f}" fill="{color}" font-size="{size}" '
            f'text-anchor="{anchor}"{style}>{"".join(parts)}</text>'
        )

    def write(self, path: Path) -> None:
        """Write the file; the title is what readers of the screen hear."""
        body = "\n".join(self.shapes)
        path.write_text(
            f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {self.width:g} {self.height:g}" '
            f'width="{self.width:g}" height="{self.height:g}" role="img" '
            f"font-family=\"Georgia, 'Times New Roman', serif\"><title>{self.title}</title>\n"
            f'<rect width="100%" height="100%" fill="white"/>\n{body}\n</svg>\n',
            encoding="utf-8",
        )


def support(sheet: Sheet, x: float, y: float) -> None:
    """Draw a bearing below a point: it holds sideways and lets tilt."""
    sheet.shape([(x, y), (x - 11, y + 19), (x + 11, y + 19)], "white")
    for step in range(-2, 3):
        sheet.line([(x + 7 * step, y + 19), (x + 7 * step - 6, y + 26)], INK, 1.0)


def throw_frame() -> None:
    """Draw a throw from the side and from the free end, with its frame and forces."""
    sheet = Sheet(760, 350, "A crank throw with its frame, its dimensions and the forces on it")
    axis, pin = 240.0, 100.0
    left, right = 90.0, 470.0
    sheet.box(left, axis - 32, 70, 64)
    sheet.box(right - 70, axis - 32, 70, 64)
    sheet.box(205, pin - 26, 150, 52)
    for x in (160.0, 355.0):
        sheet.box(x, pin - 40, 45, axis - pin + 86)
    sheet.line([(50, axis), (510, axis)], EDGE, 1.0, "9 3 2 3")
    sheet.line([(150, pin), (410, pin)], EDGE, 1.0, "9 3 2 3")
    for x in (left, right):
        support(sheet, x, axis + 32)
    sheet.arrow((280, 16), (280, pin - 28))
    sheet.text((294, 34), "Z", RED, 18)
    sheet.arrow((left - 4, axis), (left - 62, axis), BLUE)
    sheet.arrow((right + 4, axis), (right + 62, axis), BLUE)
    sheet.text((left - 48, axis - 12), "N", BLUE, 18)
    sheet.text((right + 48, axis - 12), "N", BLUE, 18)
    sheet.dimension((430, pin), (430, axis), "R", (14, 4))
    sheet.line([(400, pin), (440, pin)], EDGE, 0.8)
    y = 316.0
    for start, end, label in (
        (left, 160, "L_km /2"),
        (160, 205, "h"),
        (205, 355, "L_shm"),
        (355, 400, "h"),
        (400, right, "L_km /2"),
    ):
        sheet.dimension((start, y), (end, y), label, (0, 20))
        for x in (start, end):
            sheet.line([(x, y - 8), (x, y + 5)], EDGE, 0.8)
    sheet.arrow((left, axis), (left, axis - 92), GREEN, 1.6)
    sheet.text((left - 12, axis - 84), "y", GREEN)
    sheet.arrow((left, axis), (left + 58, axis), GREEN, 1.6)
    sheet.text((left + 52, axis - 8), "z", GREEN)
    sheet.circle((left, axis), 6, "white", GREEN)
    sheet.line([(left - 4, axis - 4), (left + 4, axis + 4)], GREEN, 1.3)
    sheet.line([(left - 4, axis + 4), (left + 4, axis - 4)], GREEN, 1.3)
    sheet.text((left - 15, axis + 18), "x", GREEN)
    sheet.text((280, axis + 26), "!free end left, flywheel right", EDGE, 12)
    center = (640.0, axis)
    sheet.shape(
        [
            (588, 120),
            (600, 70),
            (640, 55),
            (680, 70),
            (692, 120),
            (692, 270),
            (640, 290),
            (588, 270),
        ]
    )
    sheet.circle(center, 32, "white")
    sheet.circle((640, pin), 26, "white")
    sheet.arrow((640, pin), (640, pin + 70))
    sheet.text((655, pin + 58), "Z", RED, 18)
    sheet.arrow((640, pin), (722, pin))
    sheet.text((716, pin - 10), "T", RED, 18)
    sheet.arrow(center, (640, axis - 70), GREEN, 1.6)
    sheet.text((628, axis - 58), "y", GREEN)
    sheet.arrow(center, (562, axis), GREEN, 1.6)
    sheet.text((568, axis - 10), "x", GREEN)
    sheet.arc(center, 72, 100, 138, ORANGE)
    end = math.radians(140)
    tip = (640 + 72 * math.sin(end), axis - 72 * math.cos(end))
    sheet.arrow((tip[0] + 5, tip[1] - 6), tip, ORANGE, 1.5)
    sheet.text((712, axis + 58), "ω", ORANGE, 17)
    sheet.text((640, 24), "!seen from the free end", EDGE, 12)
    sheet.dimension((588, 316), (692, 316), "B", (0, 20))
    sheet.write(THEORY / "throw_frame.svg")


def slider_crank() -> None:
    """Draw a crank with a main rod, an offset cylinder and a hinged rod."""
    sheet = Sheet(760, 660, "A crank with a main rod and a hinged rod, angles and lengths")
    origin, scale = (300.0, 530.0), 1.0
    R, L, R_1, L_1, offset = 105.0, 330.0, 96.0, 250.0, 22.0
    alpha, bank, gamma = math.radians(52), math.radians(50), math.radians(50)

    def at(place: complex) -> Point:  # s + i n: s upwards, n to the right
        return (origin[0] + scale * place.imag, origin[1] - scale * place.real)

    def turn(angle: float) -> complex:
        return complex(math.cos(angle), math.sin(angle))

    crank = R * turn(alpha)
    beta = math.asin((crank.imag - offset) / L)
    piston = crank + L * turn(-beta)
    slave = crank + R_1 * turn(gamma - beta)
    own = slave * turn(-bank)
    beta_1 = math.asin(own.imag / L_1)
    other = slave + L_1 * turn(bank - beta_1)

    def cylinder(center: complex, direction: float) -> None:
        along, across = turn(direction), 1j * turn(direction)
        for side in (-1, 1):
            edge = center + side * 40 * across
            sheet.line([at(edge - 62 * along), at(edge + 58 * along)], INK, 2.4)
        sheet.shape(
            [
                at(center + a * along + c * across)
                for a, c in ((-22, -38), (26, -38), (26, 38), (-22, 38))
            ]
        )

    sheet.line([at(-40 + 0j), at(520 + 0j)], EDGE, 1.0, "9 3 2 3")
    sheet.line([at(150 + offset * 1j), at(470 + offset * 1j)], EDGE, 1.0, "3 4")
    sheet.line([at(0j), at(520 * turn(bank))], EDGE, 1.0, "9 3 2 3")
    cylinder(piston, 0.0)
    cylinder(other, bank)
    sheet.circle(at(0j), R, "none", "#c7ced6")
    arm = 9j * turn(beta * -1)
    eye = [crank + arm, piston + arm, piston - arm, crank - arm]
    sheet.shape([at(one) for one in eye], "#d5e2ef", BLUE)
    ear = [crank - 14j * turn(-beta), crank + 60 * turn(-beta), slave, crank + 20j * turn(-beta)]
    sheet.shape([at(one) for one in ear], "#d5e2ef", BLUE)
    lean = bank - beta_1
    edge = 7j * turn(lean)
    sheet.shape(
        [at(one) for one in (slave + edge, other + edge, other - edge, slave - edge)],
        "#f3e2d2",
        ORANGE,
    )
    sheet.line([at(0j), at(crank)], INK, 12)
    sheet.line([at(0j), at(crank)], SHADE, 9)
    for joint, radius in ((0j, 9), (crank, 10), (slave, 7), (piston, 8), (other, 7)):
        sheet.circle(at(joint), radius, "white")
    center = crank + (0.36 * L + 15j) * turn(-beta)
    sheet.circle(at(center), 4, INK)
    sheet.text((at(center)[0] + 15, at(center)[1] + 4), "D", INK, 15)
    sheet.arc(at(0j), 52, 0, math.degrees(alpha))
    sheet.text((at(66 * turn(0.30))[0], at(66 * turn(0.30))[1]), "α")
    sheet.arc(at(0j), 268, 0, math.degrees(bank))
    place = at(282 * turn(0.52))
    sheet.text((place[0], place[1]), "Δ")
    sheet.arc(at(piston), 104, 180 - math.degrees(beta), 180)
    place = at(piston - 104 - 12j)
    sheet.text((place[0] - 2, place[1] + 5), "β")
    place = at(crank)
    sheet.text((place[0] + 20, place[1] + 16), "A")
    place = at(0j)
    sheet.text((place[0] - 20, place[1] + 5), "O")
    place = at(piston)
    sheet.text((place[0] + 24, place[1] + 6), "B")
    place = at(slave)
    sheet.text((place[0] + 20, place[1] + 10), "P")
    place = at(other)
    sheet.text((place[0] + 4, place[1] + 30), "B_1")
    place = at(0.36 * crank)
    sheet.text((place[0] + 6, place[1] + 24), "R")
    place = at(crank + 0.62 * (piston - crank))
    sheet.text((place[0] + 22, place[1]), "L", BLUE)
    place = at(crank + 0.55 * (slave - crank))
    sheet.text((place[0] + 4, place[1] + 26), "R_1", BLUE)
    place = at(slave + 0.5 * (other - slave))
    sheet.text((place[0] + 16, place[1] + 20), "L_1", ORANGE)
    sheet.arc(at(crank), 44, math.degrees(-beta), math.degrees(gamma - beta))
    place = at(crank + 56 * turn(gamma * 0.45 - beta))
    sheet.text((place[0], place[1] + 5), "γ")
    sheet.arrow(at(piston + 86), at(piston + 30), RED)
    place = at(piston + 76)
    sheet.text((place[0] + 16, place[1] + 6), "F", RED, 18)
    sheet.arrow(at(piston - 92j), at(piston - 44j), RED)
    place = at(piston - 80j)
    sheet.text((place[0] - 2, place[1] - 10), "N", RED, 18)
    away = crank + 74j * turn(alpha)
    sheet.arrow(at(crank), at(away), RED)
    sheet.text((at(away)[0] + 14, at(away)[1] + 4), "T", RED, 18)
    inward = crank - 62 * turn(alpha)
    sheet.arrow(at(crank), at(inward), RED)
    sheet.text((at(inward)[0] + 36, at(inward)[1] + 10), "Z", RED, 18)
    sheet.dimension(at(185 + 0j), at(185 + offset * 1j), "e", (-24, 5))
    sheet.arrow((80, 560), (80, 500), GREEN, 1.6)
    sheet.text((66, 506), "s", GREEN)
    sheet.arrow((80, 560), (140, 560), GREEN, 1.6)
    sheet.text((138, 550), "n", GREEN)
    sheet.arc(at(0j), 132, 100, 128, ORANGE)
    end = math.radians(130)
    tip = (origin[0] + 132 * math.sin(end), origin[1] - 132 * math.cos(end))
    sheet.arrow((tip[0] + 5, tip[1] - 6), tip, ORANGE, 1.5)
    sheet.text((tip[0] + 22, tip[1]), "ω", ORANGE, 17)
    sheet.write(THEORY / "slider_crank.svg")


def chain() -> None:
    """Draw a crankshaft of three throws between its torsional and its axial chain."""
    sheet = Sheet(760, 430, "A crankshaft of three throws, its torsional chain and its axial chain")
    journals, axis = [70.0, 230.0, 390.0, 550.0], 205.0
    cranks = [150.0, 310.0, 470.0]
    sheet.text((16, 30), "!torsional: inertias at the cranks", EDGE, 13, "start")
    sheet.text((16, 418), "!axial: masses at the middles of the main journals", EDGE, 13, "start")
    for place, x in enumerate(cranks):
        up = -1 if place != 1 else 1
        sheet.box(x - 80, axis - 9, 42, 18)
        sheet.box(x + 38, axis - 9, 42, 18)
        top = min(axis, axis + up * 44) - 9
        for web in (x - 38, x + 24):
            sheet.box(web, top, 14, 62)
        sheet.box(x - 24, axis + up * 38 - 8, 48, 16)
    sheet.box(550, axis - 9, 26, 18)
    sheet.box(576, axis - 58, 34, 116)
    sheet.text((648, axis + 5), "!flywheel", EDGE, 13)
    upper = 82.0
    for x in [*cranks, 593.0]:
        sheet.line([(x, upper + 22), (x, axis - 50)], EDGE, 0.8, "3 4")
    ends = [*cranks, 593.0]
    for left, right, label in zip(
        ends, ends[1:], ("½( e_t1 + e_t2 )", "½( e_t2 + e_t3 )", "½ e_t3"), strict=False
    ):
        sheet.spring((left + 12, upper), (right - 12, upper))
        sheet.text(((left + right) / 2, upper - 18), label, BLUE, 14)
    for x, label in zip(ends, ("I_1", "I_2", "I_3", "I_F"), strict=True):
        sheet.box(x - 11, upper - 22, 22, 44, "#d5e2ef")
        sheet.text((x, upper - 30), label, INK, 15)
    lower = 330.0
    for x in journals:
        sheet.line([(x, axis + 12), (x, lower - 20)], EDGE, 0.8, "3 4")
    for place, (left, right) in enumerate(pairwise(journals), start=1):
        sheet.spring((left + 17, lower), (right - 17, lower))
        sheet.text(((left + right) / 2, lower - 16), f"1/ e_n{place}", BLUE, 14)
    for x, label in zip(
        journals, ("m_1 /2", "( m_1 + m_2 )/2", "( m_2 + m_3 )/2", "m_3 /2 + m_F"), strict=True
    ):
        sheet.box(x - 16, lower - 16, 32, 32, "#f3e2d2")
        sheet.text((x, lower + 36), label, INK, 14)
    sheet.arrow((journals[1] - 17, lower + 62), (journals[1] - 67, lower + 62))
    sheet.arrow((journals[2] + 17, lower + 62), (journals[2] + 67, lower + 62))
    sheet.line([(journals[1] - 17, lower + 62), (journals[2] + 17, lower + 62)], RED, 0.9, "2 4")
    sheet.text(((journals[1] + journals[2]) / 2, lower + 57), "P = c Z / e_n2", RED, 15)
    sheet.spring((journals[3] + 17, lower), (journals[3] + 100, lower))
    wall = journals[3] + 100
    sheet.line([(wall, lower - 24), (wall, lower + 24)], INK, 2.0)
    for step in range(-3, 4):
        sheet.line([(wall, lower + 7 * step), (wall + 8, lower + 7 * step - 6)], INK, 1.0)
    sheet.text((wall + 14, lower + 5), "!thrust bearing", EDGE, 13, "start")
    sheet.write(THEORY / "chain.svg")


if __name__ == "__main__":
    throw_frame()
    slider_crank()
    chain()
