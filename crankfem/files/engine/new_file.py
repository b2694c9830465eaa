"""The text of a new engine file: cylinders in line or V, with their cranks, banks and firing order."""

import math
import re
import tomllib
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from importlib.resources import files
from string import Template

import numpy as np

from crankbase.array_checks import Array
from crankbase.errors import InputError
from crankbase.sentences import written
from crankbase.written_quantity import parse_quantity
from crankfem.files.engine.mechanism_cylinders import intervals_text
from dynamics.engine.layout import EVEN, firing_intervals
from geometry.throw import CrankThrow

# Firing orders of cylinders in line, by strokes per cycle; the cranks follow from them, for firing is even.
# To eight cylinders these are usual orders, from nine on those of the rule that `engine_template` states.
IN_LINE: dict[int, dict[int, tuple[int, ...]]] = {
    strokes: {order.count("-") + 1: tuple(map(int, order.split("-"))) for order in orders.split()}
    for strokes, orders in (
        (
            4,
            """1 1-2 1-3-2 1-3-4-2 1-2-4-5-3 1-5-3-6-2-4 1-3-5-7-6-4-2 1-6-2-5-8-3-7-4
1-3-5-7-9-8-6-4-2 1-7-3-9-5-10-4-8-2-6 1-8-5-4-9-7-10-2-11-3-6 1-8-3-9-2-7-12-5-10-4-11-6
1-6-2-7-13-4-12-9-11-10-3-5-8 1-9-3-11-5-13-7-14-6-12-4-10-2-8 1-4-8-14-9-12-5-13-15-10-3-7-2-11-6
1-11-3-9-2-12-4-10-16-6-14-8-15-5-13-7 1-17-5-8-15-2-16-3-11-13-6-7-14-4-9-12-10
1-13-5-15-7-16-8-17-9-18-6-14-4-12-3-11-2-10 1-17-2-9-6-4-11-16-5-12-15-7-13-19-8-18-3-10-14
1-10-18-9-17-5-13-2-14-6-20-11-3-12-4-16-8-19-7-15""",
        ),
        (
            2,
            """1 1-2 1-3-2 1-3-2-4 1-4-3-2-5 1-5-3-4-2-6 1-7-2-5-4-3-6 1-8-3-4-7-2-5-6
1-8-3-6-5-4-7-2-9 1-9-4-7-2-10-3-5-6-8 1-7-10-4-2-11-5-6-3-9-8 1-8-6-10-2-9-4-11-3-7-5-12
1-13-2-11-4-9-6-7-8-5-10-3-12 1-9-14-2-5-12-7-6-10-3-11-8-4-13 1-14-9-6-3-15-7-5-8-13-2-10-11-4-12
1-14-8-5-13-3-12-10-7-9-4-11-15-2-6-16 1-12-14-4-9-10-8-13-5-6-17-7-2-15-11-3-16
1-10-16-14-2-13-8-3-12-18-9-7-4-6-17-15-5-11 1-19-14-9-6-13-3-17-7-11-15-2-16-4-12-8-18-10-5
1-17-10-5-19-9-3-12-15-13-6-8-18-2-14-11-16-4-7-20""",
        ),
    )
}
MOST_CYLINDERS, USUAL = 20, 8
# The angle between banks that is preferred, and the largest of any engine [deg].
USUAL_V_ANGLE, LARGEST_V_ANGLE = 60.0, 180.0


@dataclass(frozen=True)
class VAngles:
    """Angles that two banks may have, above 0 as there are two of them.

    Attributes
    ----------
    least : float
        Smallest one [deg].
    why : str
        There are no smaller ones.
    besides : str
        What is allowed as well.
    """

    least: float
    why: str
    besides: str = ""

    def __contains__(self, angle_deg: float) -> bool:
        return angle_deg > 0.0 and self.least <= angle_deg <= LARGEST_V_ANGLE

    def read(self, text: str) -> float:
        """Return the angle that --v-angle gives [deg]."""
        least = f"{self.least:g} deg" if self.least else "more than 0"
        allowed = f"{least} to {LARGEST_V_ANGLE:g} deg{self.besides}"
        angle = round(math.degrees(parse_quantity(text, "rad", "--v-angle", allowed)), 9)
        if angle not in self:
            raise InputError(f"--v-angle: given {text}; allowed is {allowed}, because {self.why}.")
        return angle


# Of the template's engine, whose bore and stroke are known, and of one of which only the crankshaft is.
TEMPLATE_V_ANGLES = VAngles(45.0, "closer banks of this engine meet", ', or "even"')
V_ANGLES = VAngles(0.0, "it is between two banks")
ABOUT = """\
# An engine file of crankfem. All values are examples of a medium-speed diesel engine, marked as assumed:
# replace them with yours, then
"""
OTHERS = Template("""\
# For others start from `crankfem new $file --cylinders 3`, a V engine from `crankfem new $file --cylinders 12
# --v-angle even`: angles, order and main bearings then fit. `--from 8chn26-26` shows rods hinged to others.
""")
# Two rods side by side need a longer pin.
IN_LINE_SIZES = {"main_journal_length": "135 mm", "pin_length": "139 mm", "beside": ""}
V_SIZES = {
    "main_journal_length": "120 mm",
    "pin_length": "190 mm",
    "beside": ": two rods side by side",
}
BANKS = Template("""\
# Axis of each cylinder. Cylinders of both banks are counted from the free end, those of the first bank first;
# the first of each bank work on the first throw, and so on.
bank_angles = { value = [$angles], assumed = "example" }
""")


def engine_template(
    file: str = "mine.toml", cylinders: int = 6, strokes: int = 4, v_angle: str | None = None
) -> str:
    """Return the text of an engine file that can be run unchanged.

    Parameters
    ----------
    file : str
        Its name, for the commands in it.
    cylinders : int
        Of both banks in a V engine, in which two work on each throw.
    strokes : int
        Per cycle, 2 or 4.
    v_angle : str, optional
        Angle between the banks, "60 deg", or "even" for `even_v_angle_deg`; without it the cylinders are in
        line.

    Notes
    -----
    Cylinders in line fire evenly; in four-stroke engines of an even number the cranks are mirrored about the
    middle of the shaft. From nine cylinders on, of all orders tried that one is taken which has the least
    M_1 + M_2 / 4 + N / 20: M_1 and M_2 are the moments on the engine of first and second order, over the
    inertia force of one cylinder at that order times the cylinder pitch, and N is how often neighbors fire
    in turn in a cycle. Of equal ones it is the one whose cylinders that fire in turn are furthest apart, at
    the least; then the one with the least bending moment of first order within the shaft. Any exchange of
    two cylinders (of two mirrored pairs, or within one) is worse by this rule.

    Each bank of a V engine fires as cylinders in line. The second one follows by the V angle, or in
    four-stroke engines by a turn more, where the firing is then as even or more even.
    """
    if strokes not in IN_LINE:
        raise InputError(
            f"--strokes: given {strokes}; allowed are 2 and 4, because cycles have as many strokes."
        )
    banks = 1 if v_angle is None else 2
    if not 1 <= cylinders <= MOST_CYLINDERS or cylinders % banks:
        even, why = ("even numbers of ", "two work on each throw") if banks == 2 else ("", "")
        raise InputError(
            f"--cylinders: given {cylinders}; allowed are {even}1 to {MOST_CYLINDERS}, because "
            f"{why or 'for these a firing order is known'}; write any other into the file."
        )
    throws, cycle = cylinders // banks, 180.0 * strokes
    fires = np.empty(throws)  # shaft angle at which each cylinder fires, first bank first [deg]
    fires[np.array(IN_LINE[strokes][throws]) - 1] = np.arange(throws) * cycle / throws
    # A cylinder that fires later has its crank so much behind the first.
    cranks = np.round(-fires % 360.0, 9) % 360.0
    like = (
        f"{'usual' if throws <= USUAL else 'few moments, firing well spread'} for {throws} in line"
    )
    arranged, bank_lines, sizes = "in line", "", IN_LINE_SIZES
    if v_angle is not None:
        angle = (
            even_v_angle_deg(cylinders, strokes)
            if v_angle == "even"
            else TEMPLATE_V_ANGLES.read(v_angle)
        )
        turns = reversed(range(strokes // 2))
        choices = [np.append(fires, (fires + angle + 360.0 * turn) % cycle) for turn in turns]
        fires = min(choices, key=lambda chosen: round(np.ptp(_intervals(chosen, strokes)), 6))
        axes = np.repeat([-0.5 * angle, 0.5 * angle], throws)
        bank_lines = BANKS.substitute(angles=angles_text(axes))
        arranged, like, sizes = f"in V of {angle:.6g} deg", f"each bank {like}", V_SIZES
    steps = _intervals(fires, strokes)
    if min(steps) < np.degrees(EVEN):
        raise InputError(
            f"--v-angle: given {v_angle}, at which cylinders of both banks fire together; allowed are other "
            'angles, or "even".'
        )
    title = f"{cylinders} {'cylinder' if cylinders == 1 else 'cylinders'} {arranged}"
    crank_angles = angles_text(np.tile(cranks, banks))
    return filled_template(
        "engine",
        {
            "title": f"{title}, {strokes}-stroke",
            "about": ABOUT,
            "file": file,
            "name": f"Example, {title}",
            "cylinders": cylinders,
            "strokes": strokes,
            "stroke": example_text("340 mm"),
            "thrust": throws + 1,
            "like": like,
            "crank_angles": f'{{ value = [{crank_angles}], assumed = "{like}" }}',
            "bank_lines": bank_lines,
            "evenly": steps_text(steps),
            "firing_order": ", ".join(map(str, 1 + np.argsort(np.round(fires, 6), kind="stable"))),
            "others": OTHERS.substitute(file=file),
            "crankshaft": filled_template("throw", sizes | {"throw_angles": angles_text(cranks)}),
            "flange": "",
            # That at which all cylinders act in phase.
            "highest_order": max(12, 2 * cylinders // strokes),
            "study": filled_template("study", {}),
        },
    )


class _Places(Template):
    """A text with places: $name or ${name}, and ${500 1/min: why} for an example of a value."""

    braceidpattern = "[^{}]+"


def example_text(example: str) -> str:
    """Write "500 1/min: why" as a value that is assumed."""
    quantity, colon, why = example.partition(":")
    return f'{{ value = "{quantity}", assumed = "example{colon}{why}" }}'


def filled_template(
    part: str, places: Mapping[str, object], example: Callable[[str], str] = example_text
) -> str:
    """Return a part of the template ("engine", "throw", "study") with its places filled in.

    `example` writes the examples of values, as `example_text`.
    """
    folder = files("crankfem.files.engine") / "template"
    template = _Places(folder.joinpath(f"{part}.toml").read_text(encoding="utf-8"))
    examples = {place: example(place) for place in template.get_identifiers() if " " in place}
    return template.substitute({**places, **examples})


def template_throw(text: str) -> CrankThrow:
    """Return the throw of a template, with the optional dimensions that stand in its comments."""
    values = tomllib.loads(re.sub("(?m)^#: ", "", text))["throw"]
    dimensions = {
        name: entry.get("value", entry) if isinstance(entry, dict) else entry
        for name, entry in values.items()
    }
    return CrankThrow.from_text(dimensions, "throw")


def even_v_angle_deg(cylinders: int, strokes: int) -> float:
    """Return the angle between banks with which a V engine fires evenly, two cylinders on each throw [deg].

    Of several between 45 and 180 deg it is the one nearest to 60 deg, the smaller of two as near; 90 deg for
    two cylinders of a four-stroke engine, which fire unevenly with any.

    Examples
    --------
    >>> [even_v_angle_deg(*engine) for engine in [(12, 4), (8, 4), (8, 2), (2, 4)]]
    [60.0, 90.0, 45.0, 90.0]
    """
    interval = 180.0 * strokes / cylinders
    # The second bank fires in the middle of the first one's intervals: an odd number of intervals later.
    # A turn more makes any number odd where a turn itself is an odd number of intervals.
    step = 1 if strokes == 4 and cylinders % 4 else 2
    angles = [interval * count for count in range(1, cylinders + 1, step)]
    usable = [angle for angle in angles if angle in TEMPLATE_V_ANGLES]
    return min(usable, key=lambda angle: abs(angle - USUAL_V_ANGLE), default=90.0)


def steps_text(steps: Array) -> str:
    """Say how an engine fires that does so at intervals [deg]."""
    if np.ptp(steps) < np.degrees(EVEN):
        return f"every {steps[0]:.6g} deg"
    return f"at intervals of {written(intervals_text(steps.tolist()))}"


def _intervals(fires_deg: Array, strokes: int) -> Array:
    """Angles from each firing to the next [deg]."""
    return np.degrees(firing_intervals(np.radians(fires_deg).tolist(), strokes))


def angles_text(angles_deg: Array) -> str:
    """Write angles [deg] as a list of quantities."""
    return ", ".join(f'"{angle:.10g} deg"' for angle in angles_deg)
