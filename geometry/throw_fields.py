"""The field of a throw that gave the dimension of a part, and the sentence that refuses it."""

from crankbase.errors import InputError
from crankbase.units.quantity import format_quantity
from geometry.parts import Cylinder, ThrowParts, WebPlate
from geometry.throw_dimensions import ThrowDimensions, web_dimension


def in_mm(value: float) -> str:
    """Write a length [m] as in refusals."""
    return format_quantity(value, "m")


def dimension_error(field: str, given: float, allowed: str, reason: str) -> InputError:
    """Make the error of a dimension [m]: given value, allowed values and reason."""
    return InputError(f"throw.{field}: given {in_mm(given)}; allowed is {allowed}, {reason}.")


def label(cylinder: Cylinder) -> str:
    """Name a journal or pin in a sentence."""
    return cylinder.name.replace("pin", "crankpin") if cylinder.is_pin else "main journal"


def cylinder_field(throw: ThrowDimensions, parts: ThrowParts, cylinder: Cylinder, kind: str) -> str:
    """Name of the field that gave a cylinder's dimension (diameter, length, fillet_radius, bore)."""
    if not cylinder.is_pin:
        name = f"main_journal_{kind}"
    else:
        place = parts.cylinders.index(cylinder) - 2 if throw.further_pins else -1
        if place >= 0 and getattr(throw.further_pins[place], kind) is not None:
            return f"further_pins[{place}].{kind}"
        name = f"pin_{kind}"
    if kind == "fillet_radius" and getattr(throw, name) is None:
        return "fillet_radius"
    return name


def web_field(throw: ThrowDimensions, web: WebPlate, kind: str) -> str:
    """Name of the field that gave a web's dimension."""
    if web.name in ("left web", "right web"):
        return web_dimension(throw, web.name.replace(" ", "_"), kind)[0]
    place = int(web.name.split()[1]) - 2
    if getattr(throw.further_pins[place], f"web_{kind}", None) is not None:
        return f"further_pins[{place}].web_{kind}"
    return f"web_{kind}"


def web_label(throw: ThrowDimensions, web: WebPlate) -> str:
    """Label of a web, where the webs differ."""
    return web.name if throw.left_web or throw.right_web or throw.further_pins else "web"
