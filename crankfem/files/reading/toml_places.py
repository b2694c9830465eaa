"""In which line of a TOML file a field is given."""

import re

HEADER = re.compile(r"\s*(\[\[?)\s*([^\[\]]+?)\s*\]")
NAME = re.compile(r"\s*([\w.-]+)\s*=")
# A field of a section, perhaps one of a list of tables or a value of a list.
FIELD = re.compile(r"[\w-]+(?:\[\d+\])?(?:\.[\w-]+(?:\[\d+\])?)*")


def line_of(text: str, field: str) -> int | None:
    r"""Return the number of the line that gives a field or begins a section, from 1.

    Parameters
    ----------
    text : str
        Of the file.
    field : str
        Such as ``throw.web_width`` or ``throw.further_pins[0].length``; of a value in a list, such as
        ``engine.crank_angles[2]``, the line of the list.

    Returns
    -------
    int or None
        None if no line gives it, or the text is no field.

    Examples
    --------
    >>> line_of('[throw]\nweb_width = "285 mm"', "throw.web_width")
    2
    """
    if not FIELD.fullmatch(field):
        return None
    wanted = {field, re.sub(r"\[\d+\]$", "", field)}
    section, counts = "", dict[str, int]()
    for number, line in enumerate(text.split("\n"), start=1):
        if header := HEADER.match(line):
            section = header[2]
            if header[1] == "[[":
                place = counts[section] = counts.get(section, -1) + 1
                section = f"{section}[{place}]"
            if section == field:
                return number
        elif (name := NAME.match(line)) and f"{section}.{name[1]}" in wanted:
            return number
    return None


def place_of(text: str, field: str) -> str | None:
    r"""Name the line that gives a field, or the section where it is missing; None if there is neither.

    Examples
    --------
    >>> place_of('[throw]\nweb_width = "285 mm"', "throw.pin_length")
    'section [throw], line 1'
    """
    if (line := line_of(text, field)) is not None:
        return f"line {line}"
    section = field.rpartition(".")[0]
    line = line_of(text, section) if section else None
    return None if line is None else f"section [{section}], line {line}"
