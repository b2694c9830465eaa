"""The speed of --speed, within the limits that the rated speed of an engine file has."""

from crankbase.errors import InputError
from crankbase.units.quantity import format_quantity, parse_quantity


def parse_speed(text: str | None) -> float | None:
    """Return the speed of --speed [rad/s], None where it is not given.

    Raises
    ------
    InputError
        If it is no speed, or outside the range of the field engine.rated_speed.

    Examples
    --------
    >>> parse_speed("5 rad/s")
    5.0
    """
    # Imported here: the sections take long to load.
    from crankbase.model import field_extra
    from crankfem.files.sections.engine_sections import Engine

    if text is None:
        return None
    speed = parse_quantity(text, "rad/s", "--speed")
    field = Engine.model_fields["rated_speed"]
    low, high = (float(field_extra(field, key)) for key in ("minimum_si", "maximum_si"))
    if not low <= speed <= high:
        shown = " to ".join(format_quantity(limit, "rad/s", 5) for limit in (low, high))
        raise InputError(
            f"--speed: given {text!r}; allowed is {shown}, because engine.rated_speed has the same limits."
        )
    return speed
