"""Properties of responses for equations and lookups; `fem.response_table` declares the rest."""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from crankbase.array_checks import Array
from crankbase.errors import InputError
from fem.material import Material

AXIAL = "axial_compliance"
TORSIONAL = "torsional_compliance"
INFLUENCE = "influence_coefficient"
TILT_RATIO = "tilt_stiffness_ratio"
# Supports, as they stand at the end of a response's name, and what they are called.
SUPPORTS = {
    "pinned": "pinned",
    "guided": "guided",
    "opposite": "neighbors opposite, 180 deg",
    "in_line": "neighbors in line, 0 deg",
}
# Responses that are above zero in every throw; influence coefficients and reactions have a sign.
ABOVE_ZERO = (
    *(AXIAL, TORSIONAL, TILT_RATIO),
    *("cross_tilt_stiffness_ratio", "mass", "fillet_stress_factor"),
)
# Responses that depend on the angle to the neighbors, and what their angle law needs.
ANGLE_LAWS: Mapping[str, tuple[str, str, str]] = {
    name: (f"{name}_in_line", f"{name}_opposite", TILT_RATIO) for name in (AXIAL, INFLUENCE)
}


@dataclass(frozen=True)
class ResponseScale:
    """Conversion between responses of a unit and dimensionless ones.

    Symbol with "{}", and factor on these.
    """

    symbol: str
    value: Callable[[Material, Any], Any]


# E is Young's modulus, rho the density, D_shm the pin diameter.
SCALES: Mapping[str, ResponseScale] = {
    "m/N": ResponseScale("{} E D_shm", lambda m, pin: 1.0 / (m.youngs_modulus * pin)),
    "rad/(N m)": ResponseScale(
        "{} E D_shm^3", lambda m, pin: 1.0 / (m.youngs_modulus * pin * pin * pin)
    ),
    "kg": ResponseScale("{} / (rho D_shm^3)", lambda m, pin: m.density * pin * pin * pin),
    "": ResponseScale("{}", lambda _, __: 1.0),
}


def fold_angle_deg(gamma_deg: float) -> float:
    """Fold an angle between neighboring cranks to 0 ... 180 deg (240 and -120 become 120)."""
    rest = math.fmod(abs(gamma_deg), 360.0)
    return 360.0 - rest if rest > 180.0 else rest


def is_positive_response(response: str) -> bool:
    """Whether a response, named as in a study or a model, is above zero by nature."""
    return response.startswith(ABOVE_ZERO)


def response_scale(unit: str, dimensions: Mapping[str, Any], material: Material) -> Any:
    """Factor from a dimensionless response to one of this SI unit; `InputError` if it has no scale."""
    if unit not in SCALES:
        raise InputError(
            f"unit: given {unit!r}; allowed are {', '.join(filter(None, SCALES))} and none, because "
            "only these have a scale made of modulus, density and pin diameter."
        )
    return SCALES[unit].value(material, dimensions["pin_diameter"])


def material_ratio(unit: str, material: Material, other: Material) -> float:
    """Response of a throw of one material divided by that of another with the same Poisson's ratio."""
    dimensions = {"pin_diameter": 1.0}
    scale, other_scale = (response_scale(unit, dimensions, each) for each in (material, other))
    return float(scale / other_scale)


GUIDED_MOMENTS = (
    "radial_end_moment_left_guided",
    "radial_end_moment_right_guided",
    "axial_end_moment_left_guided",
    "axial_end_moment_right_guided",
    "tangential_end_moment_opposed_guided",
    "tangential_end_moment_alike_guided",
)
NEIGHBOR_MOMENTS = (
    "radial_end_moment_in_line",
    "axial_end_moment_in_line",
    "tangential_end_moment_in_line",
    "tangential_end_moment_opposite",
    "cross_tilt_stiffness_ratio",
)
# Numbers that only reactions are made of.
END_MOMENTS = (*GUIDED_MOMENTS, *NEIGHBOR_MOMENTS)
# Equal to those of the left end if a throw is alike from both ends.
RIGHT_MOMENTS = {name: name.replace("left", "right") for name in GUIDED_MOMENTS if "left" in name}
# What the reactions under each kind of support are made of.
NEEDED: Mapping[str, tuple[str, ...]] = {
    "pinned": ("axial_reaction",),
    "guided": ("axial_reaction_guided", *GUIDED_MOMENTS),
    "neighbors": (*dict.fromkeys((*ANGLE_LAWS[AXIAL], *ANGLE_LAWS[INFLUENCE])), *NEIGHBOR_MOMENTS),
}


@dataclass(frozen=True)
class ThrowLengths:
    """Lengths of throws for equilibrium [m]: between the ends, from the left one to the pin, and R."""

    whole: Any
    to_pin: Any
    crank_radius: Any


def end_reactions(
    numbers: Mapping[str, Any], lengths: ThrowLengths, force: Array, gamma_deg: float | None = None
) -> Array:
    """Reactions on the ends of throws under a force on the pin, axial motion blocked.

    `numbers` are those of `NEEDED` for one support, floats or arrays; they determine the support. The
    force (..., 3) [N] is in the throw frame, none along z; `gamma_deg` the step from crank to crank,
    between neighbors. Returns force and moment on the left, then on the right end (..., 12) [N, N m];
    the left end takes the torque.
    """
    radial, along = -force[..., 1], -force[..., 0]
    if "axial_reaction" in numbers:
        push = numbers["axial_reaction"] * radial
        moments = np.zeros(4)
    elif gamma_deg is None:
        push = numbers["axial_reaction_guided"] * radial
        moments = lengths.whole * _guided_moments(numbers, radial, along, push)
    else:
        push, sized = _between_neighbors(numbers, radial, along, gamma_deg)
        moments = lengths.whole * sized
    across_left, turning_left, across_right, turning_right = moments
    # Equilibrium of moments about the left end, then of forces.
    x_right = -(turning_left + turning_right + lengths.to_pin * force[..., 0]) / lengths.whole
    y_right = (across_left + across_right - lengths.to_pin * force[..., 1]) / lengths.whole
    torque = lengths.crank_radius * force[..., 0]
    left = -force[..., 0] - x_right, -force[..., 1] - y_right, push
    right = x_right, y_right, -push
    parts = (*left, across_left, turning_left, torque, *right, across_right, turning_right, 0.0)
    return np.stack(np.broadcast_arrays(*parts), axis=-1) + 0.0  # no -0.0


def _guided_moments(numbers: Mapping[str, Any], radial: Any, along: Any, push: Any) -> Array:
    """End moments (4, ...) of guided ends about x and y, left and right, divided by the length."""
    left, right, axial_left, axial_right, opposed, alike = (
        numbers[name] for name in GUIDED_MOMENTS
    )
    return np.array(
        np.broadcast_arrays(
            axial_left * push - left * radial,
            (alike + opposed) * along,
            right * radial - axial_right * push,
            (alike - opposed) * along,
        )
    )


def _between_neighbors(
    numbers: Mapping[str, Any], radial: Any, along: Any, gamma_deg: float
) -> tuple[Any, Array]:
    """Axial reaction, and end moments (4, ...) as `_guided_moments`, between equal neighbors."""
    radial_moment, axial_moment, opposed, alike, cross = (numbers[n] for n in NEIGHBOR_MOMENTS)
    (e_0, e_180, rho), (c_0, c_180, _) = (
        [numbers[name] for name in ANGLE_LAWS[kind]] for kind in (AXIAL, INFLUENCE)
    )
    angle = np.deg2rad(gamma_deg % 360.0)
    sine, cosine, both = (
        (1.0 - np.cos(angle)) / 2.0,
        (1.0 + np.cos(angle)) / 2.0,
        np.sin(angle) / 2.0,
    )
    below, below_cross = sine + rho * cosine, sine + cross * cosine
    share, crossing = sine / below, both / below  # sigma, and sigma cot(gamma / 2)
    compliance = e_0 + (e_180 - e_0) * share
    influence = c_0 + (c_180 - c_0) * share
    lengthening = alike / axial_moment * (e_180 - e_0) * crossing * along
    push = (influence * radial - lengthening) / compliance
    held = axial_moment * push - radial_moment * radial
    across = (1.0 - share) * held - crossing * alike * along
    turning = share * alike * along - rho * crossing * held
    across_reversed = opposed * along * cross * both / below_cross
    turning_reversed = opposed * along * cross * cosine / below_cross
    moments = np.array(
        np.broadcast_arrays(
            across + across_reversed,
            turning + turning_reversed,
            across_reversed - across,
            turning - turning_reversed,
        )
    )
    return push, moments
