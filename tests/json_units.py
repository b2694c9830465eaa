"""Units of numbers in JSON, read as docs/command-line.md says: of every number there has to be one."""

from functools import cache

from crankbase.units import NoUnitError, unit_quantity


def numbers_with_units(content):
    """List (path, number, unit) of all numbers in a document, and fail where one has no unit."""
    units = content.get("units", {})
    return list(_walk({key: own for key, own in content.items() if key != "units"}, (), (), units))


def unit_key(units, path):
    """Find what tells the unit of a number: the fitting key of most names, before one with a star."""
    for start in range(len(path)):
        for last in (path[-1], "*"):
            key = ".".join((*path[start:-1], last))
            if key in units:
                return key
    raise AssertionError(f"{'.'.join(path)}: a number without a unit")


def _walk(content, path, around, units, places=()):
    if isinstance(content, dict):
        for name, own in content.items():
            if name == "said":  # values of sentences, each beside its unit
                continue
            yield from _walk(own, (*path, name), (content, *around), units)
    elif isinstance(content, list):
        for place, own in enumerate(content):
            yield from _walk(own, path, around, units, (*places, place))
    elif isinstance(content, int | float) and not isinstance(content, bool):
        unit = units[unit_key(units, path)]
        if unit.startswith("."):
            unit = _told_beside(unit.removeprefix("."), path, places, around)
        assert is_unit(unit), f"{'.'.join(path)}: {unit!r} is no unit"
        yield path, content, unit or "1"


def _told_beside(key, path, places, around):
    told = next((own[key] for own in around if key in own), None)
    assert told is not None, f"{'.'.join(path)}: nothing is called {key} beside it"
    if isinstance(told, dict) and set(told) == {"row", "per_column"}:
        row, column = places
        return f"{told['row'][row]}/{told['per_column'][column]}"
    if isinstance(told, dict):
        return told[path[-1]]
    return told[places[-1]] if isinstance(told, list) else told


@cache
def is_unit(text):
    """Tell whether a text is a unit of SI as records write it; empty or "1" is that of plain numbers."""
    try:
        one = unit_quantity(text)
    except NoUnitError:
        return text == "1"
    if text in ("deg", "1/min"):
        return True
    return abs(float(one.to_base_units().magnitude) - 1.0) < 1e-12
