"""What a number with decimal commas or separators of thousands may mean."""

import re

# Between the thousands of a number, beside the comma and the point.
_SPACES = " \u00a0\u2009\u202f"
_MARKS = rf".,'\u2019_{_SPACES}"
SEPARATED_NUMBER = rf"[+-]?\d+(?:[{_MARKS}]\d+)*\.?(?:[eE][+-]?\d+)?"
_QUANTITY = re.compile(
    rf"([+-]?)(\d[\d{_MARKS}]*?)((?:[eE][+-]?\d+)?)[\s]*((?:1\s*/\s*)?[^\W\d_].*|[%°].*|)"
)
_WHOLE = re.compile(rf"\d+|[1-9]\d{{0,2}}([{_MARKS}])\d{{3}}(?:\1\d{{3}})*")
_PLAIN = re.compile(r"\d+\.?\d*")


def readings(text: str) -> tuple[str, ...]:
    """Return what a number with separators may mean, with a decimal point alone and with its unit.

    None for a number without separators, and for what can be read in no way.

    Examples
    --------
    >>> readings("82,5 mm"), readings("1,200 mm"), readings("1 200,50 1/min")
    (('82.5 mm',), ('1.2 mm', '1200 mm'), ('1200.5 1/min',))
    >>> readings("82.5 mm"), readings("17 0 mm")
    ((), ())
    """
    found = _QUANTITY.fullmatch(text.strip())
    if found is None or _PLAIN.fullmatch(found[2]):
        return ()
    sign, digits, power, unit = found.groups()
    split = [tuple(digits.split(mark)) for mark in ",." if digits.count(mark) == 1]
    numbers = []
    for whole, fraction in (*split, (digits, "")):
        if not _WHOLE.fullmatch(whole) or not (fraction or "0").isdigit():
            continue
        thousands = re.sub(r"\D", "", whole)
        numbers.append(f"{thousands}.{fraction}".rstrip("0").rstrip("."))
    return tuple(dict.fromkeys(f"{sign}{number}{power} {unit}".strip() for number in numbers))


def either(meant: tuple[str, ...]) -> str:
    """Name in quotes what may be meant.

    Examples
    --------
    >>> either(("1.2 mm", "1200 mm"))
    '"1.2 mm" or "1200 mm", whichever is meant'
    """
    named = " or ".join(f'"{one}"' for one in meant)
    return f"{named}, whichever is meant" if len(meant) > 1 else named
