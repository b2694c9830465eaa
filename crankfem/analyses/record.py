"""Common parts of all records for JSON and tables."""

from collections.abc import Iterable, Iterator, Mapping
from functools import cache
from typing import Any

from crankbase.model import InputModel, field_extra, part_kind
from crankbase.results import Result, contents
from crankbase.results import plain as _plain
from crankbase.results import units as result_units
from crankfem.files.reading.toml_file import InputRecord
from fem.material import Material
from geometry.throw import CrankThrow

# Plain JSON content.
Record = dict[str, Any]


def assumed_values(records: Iterable[InputRecord]) -> list[Record]:
    """Return field, value, reason and effect of the assumed inputs."""
    return [
        {
            "field": record.field,
            "given": record.given,
            "reason": record.source,
            "effect": record.effect,
        }
        for record in records
        if record.assumed
    ]


def attributes(source: object, *names: str) -> Record:
    """Return attributes of an object by their names, as plain JSON content.

    Examples
    --------
    >>> attributes(2.0 + 1.0j, "real", "imag")
    {'real': 2.0, 'imag': 1.0}
    """
    return {name: _plain(getattr(source, name)) for name in names}


def plain(content: Mapping[str, Any]) -> Record:
    """Return content for JSON: arrays and tuples as lists, unbounded values as None.

    NaN stays, for `json_text` to refuse.

    Examples
    --------
    >>> plain({"orders": (0.5, 1.0), "peak": float("inf")})
    {'orders': [0.5, 1.0], 'peak': None}
    """
    return {name: _plain(value) for name, value in content.items()}


# Of names, and of names that end so: "largest_side_force" is a force. Plain numbers have the unit "1".
_WORDS = {
    "1": "correction count error errors estimate factor inflation margin number order orders ratio "
    "residual share",
    "m": "diameter diameters height length radius",
    "m^2": "area",
    "deg": "deg",
    "N": "force",
    "Pa": "pressure",
    "kg": "mass",
    "kg m": "static_moment",
    "kg m^2": "inertia",
    "W": "power",
    "J": "work",
    "Hz": "frequencies frequency",
    "1/min": "rpm",
}
# Of whole names.
_NAMES = {
    "1": "accuracy across_web added "
    "allowed asymmetry axial_correction "
    "axial_force_per_radial axial_reaction beside_chosen cases connections "
    "cranks cylinder cylinders designs detuning done elements elements_across_fillets "
    "evaluations exponent failed fluctuation held_out kept "
    "largest_error_held_out layers left_out "
    "first_mode likeness lost modes "
    "magnifier mechanical_efficiency mended_elements missing mode "
    "node_positions nodes nonuniformity overlap_per_radius phase_sum pins points "
    "misfiring resultant rho runs same_stars samples section_error sections "
    "sense severity shape "
    "strokes t throw unknowns used written",
    "m": "axis center_of_mass overlap principal_place shear_place stroke von_mises_place",
    "m^3": "volume",
    "rad": "crank_angles",
    "kg m^2": "inertia_about_shaft",
    "m/s": "mean_piston_speed",
    "rad/s": "angular_frequency speed",
    "m/N": "axial_compliance axial_rigid_sections e_0 e_180 influence influence_coefficient",
    "rad/(N m)": "torsional_compliance",
    ".unit": "bound contribution highest levels limit lower lowest peak permitted plain_sum plain_sum_peak "
    "printed repaired synthesis upper value worst",
    ".stress_unit": "principal principals shear von_mises",
    ".stiffness_units": "stiffness stiffness_error",
}
# Of ends of paths, "*" being any name.
_PLACES = {
    "1": "factors.* ratios.* "
    "axial_forces.difference constants.* errors.* kinetic_shares.* quality.* "
    "spreads.high spreads.low strain_shares.* surfaces.* used.*",
    "m": "meshings.size dimensions.value",
    "N": "axial_forces.alone axial_forces.in_shaft",
    "kg m": "unbalance.static",
    "kg m^2": "unbalance.dynamic",
    "W": "dampers.* power.largest",
    "s": "seconds.*",
    "Hz": "causes.* frequencies.high frequencies.low frequencies.nominal",
    "m/N": "errors.axial_compliance errors.influence_coefficient "
    "angle_law.fe angle_law.formulas.* fe.axial regression.axial.value",
    "rad/(N m)": "errors.torsional_compliance fe.torsional regression.torsional.value",
    ".unit": "cause.orders.amplitude free_end.orders.amplitude responses.first responses.second",
    ".stress_unit": "fillets.nominal oil_holes.nominal",
}
# Of ends of paths behind "axial" and "torsional": the units of both.
_KINDS = {
    ("m/N", "rad/(N m)"): "sources.mean_compliance",
    ("kg", "kg m^2"): "inertia modes.modal_inertia",
    ("N/m", "N m/rad"): "stiffness ground",
    ("m", "rad"): "resonances.amplitude amplitudes.nominal "
    "amplitudes.percentile_5 amplitudes.percentile_95 amplitudes.highest",
}

_HARMONICS = "mean cosine sine amplitude"
# Of what is a force here and a moment there: parts and unit, and what has them.
_GROUPS = {
    (_HARMONICS, "N m"): ("torque",),
}


def with_units(content: Record | Result) -> Record:
    """Return a record with the units of its numbers under "units"; unchanged if it has no numbers."""
    if isinstance(content, dict) and "units" in content:
        return content
    known = units_of(_undeclared(content)) | result_units(content)
    whole: Record = _plain(content)
    return whole | {"units": known} if known else whole


def _undeclared(content: Any) -> Any:
    """Return content without the values of which inputs and results declare the unit."""
    if isinstance(content, InputModel):
        return None
    if isinstance(content, Result):
        content = {
            quantity.key_of(name): getattr(content, name)
            for name, (quantity, _) in contents(type(content)).items()
            if not (quantity.unit or quantity.flat)
        }
    if isinstance(content, Mapping):
        return {name: _undeclared(part) for name, part in content.items()}
    if isinstance(content, list | tuple):
        return [_undeclared(part) for part in content]
    return content


def units_of(content: Record) -> dict[str, str]:
    """Return the units of all numbers in a record.

    Returns
    -------
    dict of str to str
        By the end of a number's path: names with dots between, lists not counted, "*" for any last name.
        Of those that match a number, the one with most names has its unit, before one with "*". "1" is the
        unit of plain numbers. A unit that begins with a dot names the key, next to the number or in the next
        object around it, with the unit: as text, or by name or position like the numbers. Numbers without a
        declaration are left out.
    """
    units = {}
    for path in dict.fromkeys(number_paths(content)):
        known = _unit_at(path)
        if known is not None:
            key, unit = known
            units[key] = unit
    return units


def number_paths(content: object, path: tuple[str, ...] = ()) -> Iterator[tuple[str, ...]]:
    """Iterate over the names that lead to each number of JSON content."""
    if isinstance(content, Mapping):
        for name, value in content.items():
            yield from number_paths(value, (*path, str(name)))
    elif isinstance(content, list | tuple):
        for value in content:
            yield from number_paths(value, path)
    elif isinstance(content, int | float) and not isinstance(content, bool):
        yield path


def _unit_at(path: tuple[str, ...]) -> tuple[str, str] | None:
    """Find the unit of the number at a path, and the end of the path that determines it."""
    places = _places()
    for start in range(len(path)):
        for last in (path[-1], "*"):
            key = ".".join((*path[start:-1], last))
            if key in places:
                return key, places[key]
    unit = _unit_of_name(path[-1]) if path else None
    return None if unit is None else (path[-1], unit)


@cache
def _places() -> dict[str, str]:
    """The declared ends of paths of more than one name."""
    by_name = _by_name(_PLACES)
    for units, places in _KINDS.items():
        for kind, unit in zip(("axial", "torsional"), units, strict=True):
            by_name |= {f"{kind}.{place}": unit for place in places.split()}
    for (parts, unit), names in _GROUPS.items():
        by_name |= {f"{name}.{part}": unit for name in names for part in parts.split()}
    return by_name


def _by_name(declared: Mapping[str, str]) -> dict[str, str]:
    return {name: unit for unit, names in declared.items() for name in names.split()}


@cache
def _unit_of_name(name: str) -> str | None:
    """Find the unit of an unambiguous name, as a field of input, from itself or its last words."""
    own = name.rpartition(".")[2]  # of a field such as "further_pins.0.length"
    parts = own.split("_")
    ends = {"_".join(parts[start:]) for start in range(len(parts))}
    known = _fields(CrankThrow) | _fields(Material) | _by_name(_NAMES)
    if own in known:
        return known[own]
    unit = next((unit for word, unit in _by_name(_WORDS).items() if word in ends), None)
    return _unit_of_response(name) if unit is None else unit


def _unit_of_response(name: str) -> str | None:
    from fem.responses import RESPONSES  # which takes a second to load, and few records have any

    return (RESPONSES[name].unit or "1") if name in RESPONSES else None


def _fields(model: type[InputModel]) -> dict[str, str]:
    """Units of a record of input and of its parts by field; those of a choice by its number."""
    fields: dict[str, str] = {}
    for name, info in model.model_fields.items():
        part = part_kind(info)
        units = {name: field_extra(info, "unit") or "1"} if part is None else _fields(part)
        fields |= units | fields  # of fields alike the outermost is meant
    return fields
