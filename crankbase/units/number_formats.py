"""How numbers are written without their units: so many digits, in an engineer's words."""

import math

UNBOUNDED = "unbounded"


def format_number(value: float, digits: int) -> str:
    """Format a number with so many significant digits or, if it is large, all before the point.

    Examples
    --------
    >>> format_number(57.25, 3), format_number(1234.5, 3)
    ('57.2', '1234')
    """
    text = f"{value:.{digits}g}"
    return f"{value:.0f}" if "e+" in text else text


def compact(value: float, digits: int = 3) -> str:
    """Write a number with so many digits at most, and a power of ten as in engine files.

    Examples
    --------
    >>> compact(1.4e8), compact(0.5)
    ('1.4e8', '0.5')
    """
    return f"{value:.{digits}g}".replace("e+0", "e").replace("e+", "e")


def significant(value: float, digits: int = 4) -> str:
    """Format a number with so many significant digits, zeros at its end included; see `format_number`.

    Examples
    --------
    >>> significant(1.6)
    '1.600'
    >>> significant(15597.0)
    '15597'
    """
    text = f"{value:#.{digits}g}"
    return f"{value:.0f}" if "e+" in text else text.removesuffix(".")


def nano(value: float, digits: int = 4) -> str:
    """Write a number in 1e-9 of its unit."""
    return significant(value * 1e9, digits)


def percent(share: float, digits: int = 2) -> str:
    """Write a share in per cent; what is next to nothing as that.

    Examples
    --------
    >>> percent(0.00958)
    '0.96'
    >>> percent(12.345)
    '1234'
    >>> percent(2e-12)
    'below 0.001'
    """
    hundredfold = share * 100.0
    return "below 0.001" if 0.0 < abs(hundredfold) < 1e-3 else format_number(hundredfold, digits)


def fixed(value: float, digits: int = 1) -> str:
    """Write a number with so many digits behind the point; round-off is a plain zero."""
    return f"{round(value, digits) + 0.0:.{digits}f}"


def scaled(value: float | None, size: float, digits: int = 3) -> str:
    """Write a number in units of `size`."""
    return UNBOUNDED if value is None else significant(value / size, digits)


def tiny(value: float) -> str:
    """Write the size of an error that is round-off, or nearly.

    Examples
    --------
    >>> tiny(3.87e-13)
    '4e-13'
    """
    return "0" if value == 0.0 else f"{abs(value):.0e}".replace("e-0", "e-")


def format_usage(share: float | None) -> str:
    """Format how much of a limit is used; what is unbounded as that, what exceeds it above 100 %.

    Examples
    --------
    >>> format_usage(0.9996), format_usage(1.0021)
    ('100 %', '100.2 %')
    """
    if share is None:
        return UNBOUNDED
    text = format_number(100.0 * share, 3)
    return f"{exceeding(share) if share > 1.0 and text == '100' else text} %"


def exceeding(share: float) -> str:
    """Format a share slightly above one in percent, with the first digit that is above."""
    excess = 100.0 * (share - 1.0)
    digits = max(0, -math.floor(math.log10(excess)))
    return f"{100.0 + excess:.{digits}f}"
