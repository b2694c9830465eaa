"""Load cases of a throw for CalculiX, one linear static step each."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from crankbase.errors import InputError
from fem.superelement import RX, RY, RZ, UX, UY, UZ
from fem.throw_frames import MOTIONS
from geometry.mesh import ThrowMesh

Support = Literal["pinned", "guided"]
# Motions of an end section that a support holds at both ends. The left end is held along and about the
# shaft as well.
HELD_BOTH: dict[str, tuple[int, ...]] = {"pinned": (UX, UY), "guided": (UX, UY, RX, RY)}
HELD_LEFT = (UZ, RZ)


@dataclass(frozen=True)
class LoadCase:
    """One linear static step: the supports and loads of the throw.

    Attributes
    ----------
    title : str
        Its description, for the deck's comments.
    support : {"pinned", "guided"}
        As for `fem.supports`; the left end is held along and about the shaft too.
    end_loads : (12,) tuple of float
        Forces [N] and moments [N m] on the left, then on the right end section.
    pin_forces : tuple of (3,) tuples of float
        Force on each pin in the throw frame [N], spread uniformly over its surface; empty for none.
    blocked : bool
        Whether the right end is also held along the shaft.

    Raises
    ------
    InputError
        If the support is unknown, a load is not a finite number, there are not twelve end loads, or one
        acts on a motion that is held.
    """

    title: str
    support: Support = "pinned"
    end_loads: tuple[float, ...] = (0.0,) * 12
    pin_forces: tuple[tuple[float, float, float], ...] = ()
    blocked: bool = False

    def __post_init__(self) -> None:
        if self.support not in HELD_BOTH:
            raise InputError(
                f'support: given {self.support!r}; allowed are "pinned" and "guided", because other supports '
                "need more than one throw."
            )
        if len(self.end_loads) != 12 or any(len(force) != 3 for force in self.pin_forces):
            raise InputError(
                f"load case {self.title!r}: given {len(self.end_loads)} end loads and the pin forces "
                f"{self.pin_forces!r}; allowed are 12 end loads and 3 numbers for each pin, because an "
                "end section has six motions and a pin force three components."
            )
        if not np.all(np.isfinite([*self.end_loads, *(x for f in self.pin_forces for x in f)])):
            raise InputError(
                f"load case {self.title!r}: given the end loads {self.end_loads!r} and the pin forces "
                f"{self.pin_forces!r}; allowed are finite numbers, because CalculiX reads no others."
            )
        loaded = [place for place in self.held if self.end_loads[place] != 0.0]
        if loaded:
            raise InputError(
                f"load case {self.title!r}: given a load on {_motion_name(loaded[0])}; allowed are loads "
                "on motions that are free, because a support would take it at once."
            )

    @property
    def held(self) -> tuple[int, ...]:
        """Indices, of the twelve motions of the ends, that are held."""
        both = HELD_BOTH[self.support]
        right = (*both, UZ) if self.blocked else both
        return (*sorted({*both, *HELD_LEFT}), *(6 + place for place in sorted(right)))


def axial_case(support: Support = "pinned") -> LoadCase:
    """Pull with 1 N: the right center's uz is the axial compliance e_n [m/N]."""
    return LoadCase(f"axial force of 1 N, {support}", support, _on_right(UZ))


def torque_case(support: Support = "pinned") -> LoadCase:
    """Twist with 1 N m: the right end's rz is the torsional compliance [rad/(N m)]."""
    return LoadCase(f"torque of 1 N m, {support}", support, _on_right(RZ))


def bending_case(axis: Literal["x", "y"]) -> LoadCase:
    """Bend with opposite moments of 1 N m at the pinned ends: their tilts differ by the compliance.

    The moment about x bends the throw in the crank plane, that about y across it.
    """
    if axis not in ("x", "y"):
        raise InputError(
            f'axis: given {axis!r}; allowed are "x" and "y", because z is the shaft axis.'
        )
    place = RX if axis == "x" else RY
    loads = tuple(-1.0 if i == place else 1.0 if i == 6 + place else 0.0 for i in range(12))
    return LoadCase(f"opposite end moments of 1 N m about {axis}, pinned", "pinned", loads)


def pin_case(
    pin_forces: Iterable[Sequence[float]], support: Support = "pinned", *, blocked: bool
) -> LoadCase:
    """Load the pins: free to lengthen for the influence coefficient, blocked for the reactions.

    Parameters
    ----------
    pin_forces : (pins, 3) array_like
        Force on each pin in the throw frame [N].
    support : {"pinned", "guided"}
    blocked : bool
        Whether the right end is held along the shaft.
    """
    forces = tuple((float(x), float(y), float(z)) for x, y, z in pin_forces)
    ends = "length blocked" if blocked else "free to lengthen"
    title = f"pin forces {', '.join(map(str, forces))} N, {support}, {ends}"
    return LoadCase(title, support, pin_forces=forces, blocked=blocked)


def standard_cases(mesh: ThrowMesh) -> tuple[LoadCase, ...]:
    """All load cases for the behavior of a pinned or guided throw.

    Parameters
    ----------
    mesh : ThrowMesh

    Returns
    -------
    tuple of LoadCase
        Axial force and torque under both supports, end moments about x and y, and a force of 1 N on
        each pin along each axis under both supports, the length blocked and free.
    """
    supports: tuple[Support, ...] = ("pinned", "guided")
    cases = [make(support) for make in (axial_case, torque_case) for support in supports]
    cases += [bending_case("x"), bending_case("y")]
    units = np.eye(3 * len(mesh.pins)).reshape(-1, len(mesh.pins), 3).tolist()
    cases += [
        pin_case(forces, support, blocked=blocked)
        for support in supports
        for blocked in (True, False)
        for forces in units
    ]
    return tuple(cases)


def _on_right(place: int) -> tuple[float, ...]:
    return tuple(float(i == 6 + place) for i in range(12))


def _motion_name(place: int) -> str:
    return f"{MOTIONS[place % 6]} of the {'left' if place < 6 else 'right'} end"
