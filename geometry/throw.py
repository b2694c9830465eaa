"""One crank throw: its dimensions, what they mean, and which of them can be built."""

import math
from typing import ClassVar, Self

from pydantic import model_validator

from geometry.errors import InputError
from geometry.model import InputModel, quantity_field
from geometry.quantity import show_quantity

# A fillet may take this share of a journal's length (two fillets share one journal), so that a
# tenth of it stays a cylinder for the bearing and for the pin load.
FILLET_SHARE_OF_LENGTH = 0.45
# Below this share of the journal diameter a fillet acts as a sharp corner, and meshing it only
# costs unknowns.
SMALLEST_FILLET_SHARE = 0.01
# The web must be wider than an unfilleted journal by this share of its diameter.
SMALLEST_LEDGE = 1e-3


class CrankThrow(InputModel):
    """The dimensions of one crank throw, from the middle of one main journal to that of the next.

    Both webs are equal: obround plates (the hull of two circles of diameter B about the shaft and
    the crankpin axis). Fillets of one radius run round both ends of journals and pin, on the web.

    Parameters
    ----------
    crank_radius, main_journal_diameter, pin_diameter : float
        R, D_km, D_shm [m].
    main_journal_length, pin_length : float
        L_km, L_shm [m], each between the webs (of the main journal, half belongs to each throw).
    web_width, web_thickness : float
        B, h [m].
    fillet_radius : float, optional
        Radius of the fillets at main journals and pin [m]; 0 for sharp corners.

    Raises
    ------
    InputError
        If a dimension is missing, out of range, or does not fit the others.

    Examples
    --------
    >>> throw = CrankThrow(
    ...     crank_radius=0.170, main_journal_diameter=0.220, pin_diameter=0.180,
    ...     main_journal_length=0.120, pin_length=0.139, web_width=0.285, web_thickness=0.068,
    ...     fillet_radius=0.012,
    ... )
    >>> round(throw.length, 6)
    0.395
    """

    section: ClassVar[str] = "throw"

    crank_radius: float = quantity_field(
        "crank radius, half the stroke", "m", symbol="R", minimum=0.005, maximum=2.5
    )
    main_journal_diameter: float = quantity_field(
        "main journal diameter", "m", symbol="D_km", minimum=0.005, maximum=2.0
    )
    pin_diameter: float = quantity_field(
        "crankpin diameter", "m", symbol="D_shm", minimum=0.005, maximum=2.0
    )
    main_journal_length: float = quantity_field(
        "main journal length between the webs", "m", symbol="L_km", minimum=0.002, maximum=2.0
    )
    pin_length: float = quantity_field(
        "crankpin length between the webs", "m", symbol="L_shm", minimum=0.002, maximum=2.0
    )
    web_width: float = quantity_field(
        "web width across the crank", "m", symbol="B", minimum=0.005, maximum=4.0
    )
    web_thickness: float = quantity_field(
        "web thickness along the shaft", "m", symbol="h", minimum=0.002, maximum=1.5
    )
    fillet_radius: float = quantity_field(
        "fillet radius at main journals and pin",
        "m",
        symbol="r",
        minimum=0.0,
        maximum=0.3,
        default=0.0,
    )

    @model_validator(mode="after")
    def _fits_together(self) -> Self:
        _check_web_width(self)
        _check_fillet(self)
        _check_proportions(self)
        return self

    @property
    def length(self) -> float:
        """Length of the throw along the shaft, the distance of the main bearings [m]."""
        return self.main_journal_length + 2.0 * self.web_thickness + self.pin_length

    @property
    def overlap(self) -> float:
        """Overlap s of main journal and pin, negative where none [m]."""
        return 0.5 * (self.main_journal_diameter + self.pin_diameter) - self.crank_radius

    @property
    def volume(self) -> float:
        """Volume of the throw [m^3], by the closed form of its parts."""
        web = math.pi / 4.0 * self.web_width**2 + self.web_width * self.crank_radius
        journals = 0.0
        for diameter, length in (
            (self.main_journal_diameter, self.main_journal_length),
            (self.pin_diameter, self.pin_length),
        ):
            journals += math.pi / 4.0 * diameter**2 * length
            journals += 2.0 * _fillet_ring_volume(diameter / 2.0, self.fillet_radius)
        return 2.0 * web * self.web_thickness + journals


def _fillet_ring_volume(journal_radius: float, fillet_radius: float) -> float:
    """Volume between a cylinder, a flat web face and the fillet that joins them (Pappus) [m^3]."""
    area = fillet_radius**2 * (1.0 - math.pi / 4.0)
    # Centroid of the square r x r less its quarter circle, from the journal's surface.
    square = fillet_radius**2 * 0.5 * fillet_radius
    quarter = math.pi / 4.0 * fillet_radius**2 * (1.0 - 4.0 / (3.0 * math.pi)) * fillet_radius
    if area == 0.0:
        return 0.0
    centroid = (square - quarter) / area
    return 2.0 * math.pi * (journal_radius + centroid) * area


def _check_web_width(throw: CrankThrow) -> None:
    for name, label, diameter in (
        ("main_journal_diameter", "main journal", throw.main_journal_diameter),
        ("pin_diameter", "crankpin", throw.pin_diameter),
    ):
        # A journal whose surface is also that of the web cannot be meshed; a fillet keeps them apart.
        limit = throw.web_width / (1.0 if throw.fillet_radius > 0.0 else 1.0 + SMALLEST_LEDGE)
        if diameter > limit:
            raise InputError(
                f"throw.{name}: given {show_quantity(diameter, 'm')}; allowed is at most "
                f"{show_quantity(limit, 'm')} with a web width of {show_quantity(throw.web_width, 'm')}, "
                f"or the {label} would stand outside the web."
            )


def _check_fillet(throw: CrankThrow) -> None:
    radius = throw.fillet_radius
    if radius == 0.0:
        return
    limits = [
        (
            FILLET_SHARE_OF_LENGTH * throw.main_journal_length,
            f"the main journal of {show_quantity(throw.main_journal_length, 'm')} is too short for two "
            "larger fillets",
        ),
        (
            FILLET_SHARE_OF_LENGTH * throw.pin_length,
            f"the crankpin of {show_quantity(throw.pin_length, 'm')} is too short for two larger fillets",
        ),
        (
            0.5 * (throw.web_width - throw.main_journal_diameter),
            f"the web of {show_quantity(throw.web_width, 'm')} is too narrow for a larger one round the "
            f"main journal of {show_quantity(throw.main_journal_diameter, 'm')}",
        ),
        (
            0.5 * (throw.web_width - throw.pin_diameter),
            f"the web of {show_quantity(throw.web_width, 'm')} is too narrow for a larger one round the "
            f"crankpin of {show_quantity(throw.pin_diameter, 'm')}",
        ),
    ]
    highest, reason = min(limits, key=lambda limit: limit[0])
    lowest = SMALLEST_FILLET_SHARE * max(throw.main_journal_diameter, throw.pin_diameter)
    if radius > highest * (1.0 + 1e-12):
        if highest < lowest:
            allowed = "only 0 (sharp corners)"
        else:
            allowed = f"0, or {show_quantity(lowest, 'm')} to {show_quantity(highest, 'm')}"
        raise InputError(
            f"throw.fillet_radius: given {show_quantity(radius, 'm')}; allowed is {allowed}, "
            f"because {reason}."
        )
    if radius < lowest:
        raise InputError(
            f"throw.fillet_radius: given {show_quantity(radius, 'm')}; allowed is 0, or "
            f"{show_quantity(lowest, 'm')} to {show_quantity(highest, 'm')}, because a smaller one acts as "
            "a sharp corner (give 0)."
        )


def _check_proportions(throw: CrankThrow) -> None:
    """Refuse parts so thin or short that a mesh of them would never end."""
    largest = max(throw.main_journal_diameter, throw.pin_diameter, throw.crank_radius)
    lowest = largest / 25.0
    for name in ("web_thickness", "main_journal_length", "pin_length"):
        value = float(getattr(throw, name))
        if value < lowest:
            raise InputError(
                f"throw.{name}: given {show_quantity(value, 'm')}; allowed is "
                f"{show_quantity(lowest, 'm')} or more beside the throw's other dimensions (up to "
                f"{show_quantity(largest, 'm')}), because a thinner part cannot be meshed sensibly."
            )
