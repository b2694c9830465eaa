"""The text of an engine file for a crankshaft from CAD: what the solid tells, and examples of the rest."""

import math
import os
import shlex
from collections.abc import Mapping, Sequence
from functools import partial
from pathlib import Path
from string import Template

import numpy as np

from crankfem.files.engine.new_file import (
    BANKS,
    IN_LINE,
    angles_text,
    filled_template,
    steps_text,
)
from crankfem.satellites.cad.run import FLANGE, CadRun
from dynamics.engine.layout import (
    even_firing_order,
    firing_angles_of_order,
    firing_intervals,
    least_uneven_order,
)

# Of the crank radius to which the template's examples belong [m]; similar engines have equal stresses and
# piston speeds, so that a value of this unit varies with this power of the size.
EXAMPLE_RADIUS = 0.17
POWERS = {"mm": 1, "kg": 3, "kg m^2": 5, "1/min": -1, "N/m": 1, "MPa": 0}
STEEL_TEXT = (
    ("youngs_modulus", '"210 GPa"'),
    ("poisson_ratio", "0.3"),
    ("density", '"7850 kg/m^3"'),
)
BANK_OF_EACH = """\
# Axis of each cylinder, of the banks in turn.
bank_angles = { value = [$angles], assumed = "example" }
"""
# Angles of cranks are alike to this [deg].
ALIKE = 0.01


def engine_text(
    run: CadRun,
    path: Path,
    dimensions: Mapping[int, str] | None = None,
    v_angle_deg: float | None = None,
) -> str:
    """Return the text of an engine file for a crankshaft, which runs unchanged.

    Parameters
    ----------
    run : CadRun
        With the throws' files kept.
    path : Path
        Of the engine file; those of the throws are named as seen from its folder.
    dimensions : mapping of int to str, optional
        Number of the first throw of a kind to its dimensions, "" for none.
    v_angle_deg : float, optional
        Angle between two banks, whose cylinders work on each pin together, or on the pins of a throw in turn;
        without it the cylinders are in line, one on each pin.
    """
    shaft, source = run.shaft, Path(run.file).name
    cranks = [round(pin.angle_deg, 6) for pin in sorted(shaft.pins, key=lambda pin: pin.start)]
    pins, throws = len(cranks), len(run.throws)
    axes, arranged, written_banks = [0.0] * pins, "in line, one on each pin", ""
    if v_angle_deg is not None and pins > throws:
        axes = [(-0.5, 0.5)[number % 2] * v_angle_deg for number in range(pins)]
        arranged, written_banks = "in V, one on each pin", BANK_OF_EACH
    elif v_angle_deg is not None:
        axes, cranks = [-0.5 * v_angle_deg] * pins + [0.5 * v_angle_deg] * pins, 2 * cranks
        arranged, written_banks = "in V, two on each pin", BANKS.template
    # The first pin of a throw may be that of either bank.
    strokes, fires, order, like, axes = min(
        (_fired(cranks, each) for each in (axes, [-axis for axis in axes])),
        key=lambda fired: (-fired[0], round(np.ptp(firing_intervals(fired[1], fired[0])), 6)),
    )
    radius, of_solid = shaft.throws[0].crank_radius, f'source = "{source}"'
    of_cylinders = Template(written_banks).substitute(angles=angles_text(np.array(axes)))
    if pins > throws:
        on_throws = ", ".join(str(1 + place * throws // pins) for place in range(pins))
        of_cylinders += f"throws = [{on_throws}]\n"
    flange = "".join(
        f"# Its mass and inertia include those of the flange, {end.mass:.4g} kg and "
        f"{end.inertia_about_shaft:.4g} kg m^2.\n"
        f'overhang = {{ value = "{_millimeters(end.length)}", source = "{source}: far side of the '
        'flange" }\n'
        for end in run.ends
        if end.name == FLANGE
    )
    return filled_template(
        "engine",
        {
            "title": f"The engine of the crankshaft in {source}",
            "about": f'# Written by crankfem from "{source}", which gives throws, angles, masses and stroke. '
            f"Values\n# marked as assumed are examples of this stroke, cylinders {arranged}: replace them, "
            "then\n",
            "file": shlex.quote(path.name),
            "name": path.stem,
            # CAD tells neither; a V engine's shaft looks like one in line.
            "cylinders": f'{{ value = {len(cranks)}, assumed = "{arranged}" }}',
            "strokes": f'{{ value = {strokes}, assumed = "{like}" }}',
            "stroke": f'{{ value = "{_millimeters(2.0 * radius)}", {of_solid} }}',
            "thrust": throws + 1,
            "like": like,
            "crank_angles": f"{{ value = [{angles_text(np.array(cranks))}], {of_solid} }}",
            "bank_lines": of_cylinders,
            "evenly": steps_text(np.degrees(firing_intervals(fires, strokes))),
            "firing_order": ", ".join(map(str, order)),
            "others": "",
            "crankshaft": _shaft(run, path, of_solid, dimensions, pins > throws),
            "flange": flange,
            "highest_order": max(12, 2 * len(cranks) // strokes),
            "study": "",
        },
        partial(_example_of_size, radius / EXAMPLE_RADIUS),
    )


def _example_of_size(scale: float, example: str) -> str:
    """Write an example of the template for an engine so many times as large."""
    quantity, colon, why = example.partition(":")
    number, unit = quantity.split(" ", 1)
    value = float(f"{float(number) * scale ** POWERS[unit]:.3g}")
    return f'{{ value = "{value:g} {unit}", assumed = "example of this stroke{colon}{why}" }}'


def firing_order(
    cranks_deg: Sequence[float], axes_deg: Sequence[float]
) -> tuple[int, tuple[int, ...], int, str]:
    """Return strokes, firing order and sense of rotation of cylinders with these cranks and axes, and why.

    The shaft turns against (-1) or, of cylinders in line, perhaps in the sense in which its angles count, as
    the usual order needs it.

    Examples
    --------
    >>> firing_order([0.0, 180.0, 180.0, 0.0], [0.0] * 4)
    (4, (1, 3, 4, 2), -1, 'usual for 4 in line with these cranks')
    """
    count = len(cranks_deg)
    for strokes, orders in IN_LINE.items() if not any(axes_deg) else ():
        for order in filter(None, [orders.get(count)]):
            steps = np.argsort(order) * 180.0 * strokes / count
            for sense in (-1, 1):
                off = (sense * steps - cranks_deg + 180.0) % 360.0 - 180.0
                if np.abs(off).max() < ALIKE:
                    return strokes, order, sense, f"usual for {count} in line with these cranks"
    tops = _tops(cranks_deg, axes_deg, -1)
    for strokes in IN_LINE:
        if even := even_firing_order(tops, strokes):
            return strokes, even, -1, "even with these cranks"
    least = least_uneven_order(tops, 4)
    order = tuple(map(int, 1 + np.argsort(tops, kind="stable"))) if least is None else least[0]
    return 4, order, -1, "least uneven with these cranks"


def _fired(
    cranks: Sequence[float], axes: list[float]
) -> tuple[int, tuple[float, ...], tuple[int, ...], str, list[float]]:
    """Strokes, firing angles [rad], firing order and why, and the axes."""
    strokes, order, sense, like = firing_order(cranks, axes)
    fires = firing_angles_of_order(order, _tops(cranks, axes, sense), strokes)
    return strokes, fires, order, like, axes


def _tops(cranks_deg: Sequence[float], axes_deg: Sequence[float], sense: int) -> list[float]:
    """Shaft angle at which each crank is along its cylinder's axis [rad]."""
    return [
        math.radians((axis + sense * crank) % 360.0)
        for crank, axis in zip(cranks_deg, axes_deg, strict=True)
    ]


def _shaft(
    run: CadRun, path: Path, source: str, dimensions: Mapping[int, str] | None, several_pins: bool
) -> str:
    """Write the throws, how they follow each other, the ends and the material."""
    kinds = list(dict.fromkeys(throw.file for throw in run.throws))
    names = [chr(ord("a") + number) for number in range(len(kinds))]
    lines = ["# ---- The crankshaft ".ljust(110, "-"), ""]
    for file, name in zip(kinds, names, strict=True):
        throw = next(each for each in run.throws if each.file == file)
        assert file is not None
        lines += [
            f"# {throw.mass:.5g} kg, {throw.inertia_about_shaft:.5g} kg m^2 about the shaft.",
            "[throw]" if len(kinds) == 1 else f"[throws.{name}]",
            f'file = "{Path(os.path.relpath(file, path.parent.resolve())).as_posix()}"',
        ]
        if text := (dimensions or {}).get(throw.number):
            lines.append(
                "# In place of file, within 1 % of its e_n, torsional compliance and mass:"
            )
            lines += [f"#: {line}" for line in text.split("\n")]
        lines.append("")
    layout = []
    if len(kinds) > 1:
        of_each = ", ".join(f'"{names[kinds.index(throw.file)]}"' for throw in run.throws)
        layout.append(f"throws = [{of_each}]")
    if several_pins:
        angles = np.array([throw.angle_deg for throw in run.throws])
        layout.append(f"throw_angles = {{ value = [{angles_text(angles)}], {source} }}")
    lines += ["[shaft]", *layout, ""] if layout else []
    ends = []
    for end in run.ends:
        names_of = ("free_end_diameter", "free_end_length")
        if end.name == FLANGE:
            names_of = ("flange_diameter", "flange_thickness")
        diameter = math.sqrt(8.0 * end.inertia_about_shaft / end.mass)
        length = end.mass / run.material.density / (0.25 * math.pi * diameter**2)
        if length < 0.0005:
            continue
        ends += [
            f'{name} = {{ value = "{_millimeters(size)}", {source} }}'
            for name, size in zip(names_of, (diameter, length), strict=True)
        ]
    if ends:
        lines += ["# As cylinders of the same mass and inertia.", "[shaft_ends]", *ends, ""]
    lines += ["[material]"]
    lines += [f'{name} = {{ value = {value}, assumed = "steel" }}' for name, value in STEEL_TEXT]
    return "\n".join([*lines, "", ""])


def _millimeters(length: float) -> str:
    return f"{1e3 * length:.9g} mm"
