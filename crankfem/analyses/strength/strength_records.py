"""Strength of a crankshaft as plain numbers in SI units, and the tables made from them."""

from dataclasses import asdict, fields

from crankbase.errors import InputError
from crankbase.tables.table import SI, Column, OutputUnits, Table
from crankbase.units.units import RPM, UNBOUNDED
from crankfem.analyses.record import Record, attributes, plain
from crankfem.analyses.strength.engine_strength import EQUAL, EngineStrength, ThrowStrength
from dynamics.strength.concentration import (
    FACTORS,
    RANGES,
    SYMBOLS,
    ConcentrationFactors,
    ElementFactors,
)
from dynamics.strength.fatigue import REQUIRED


def strength_record(found: EngineStrength) -> Record:
    """Return the record of a crankshaft's strength; null where an equivalent stress is unbounded."""
    return {
        **attributes(
            found, "sentence", "passed", "source", "left_out", "unsafe", "warning", "by_elements"
        ),
        "remarks": list(found.remarks),
        "required_factor": REQUIRED,
        "throws": [_throw(own) for own in found.throws],
    }


def _throw(own: ThrowStrength) -> Record:
    torque, fit = own.torque, own.fit
    return {
        "throw": own.number,
        "alternating_torque": plain({"torque": torque.value})["torque"],
        "torque_speed_rpm": torque.speed * RPM,
        "misfiring": list(torque.cylinders),
        "places": [
            plain(asdict(one) | attributes(one, "acceptability", "passed")) for one in own.places
        ],
        "webs": {
            name: _factors(own.factors.get(name), own.elements.get(name))
            for name in dict.fromkeys([*own.factors, *own.elements])
        },
        "shrink_fit": None
        if fit is None
        else asdict(fit)
        | attributes(fit, "largest_bore", "least_shrinkage", "most_shrinkage")
        | attributes(fit, "passed", "refusals", "remarks"),
    }


def _factors(formulas: ConcentrationFactors | None, elements: ElementFactors | None) -> Record:
    """Return ratios and factors of a web; None for factors that the rule or the mesh lacks."""
    known = formulas or elements
    assert known is not None
    found: Record = {name: known.web.ratio(name) for name in RANGES}
    found = {"ratios": found, "factors": dict.fromkeys(FACTORS), "finite_elements": None}
    for name in FACTORS if formulas else ():
        try:
            found["factors"][name] = getattr(formulas, name)
        except InputError:
            found["factors"][name] = None
    if elements is not None:
        found["finite_elements"] = {
            one.name: getattr(elements, one.name) for one in fields(elements) if one.name != "web"
        }
    return found


def strength_table(record: Record, units: OutputUnits = SI) -> Table:
    """Return the least acceptability factor of each location of each throw, from the `strength_record`."""
    places = [one for throw in record["throws"] for one in throw["places"]]
    hardened = any(one["depth"] for one in places)
    deep = [Column("depth", units.of("mm"), missing="surface")] if hardened else []
    return Table(
        "Alternating stresses by UR M53",
        [
            Column("throw"),
            Column("location", words=True),
            *deep,
            *(Column(f"nominal {name}", "MPa") for name in ("bending", "torsion")),
            *(Column(name, "MPa") for name in ("bending", "torsion", "added", "equivalent")),
            Column("fatigue strength", "MPa"),
            Column("factor Q", decimals=3),
        ],
        [
            [
                one["throw"],
                " ".join(filter(None, (one["place"], one["web"].removesuffix(" web")))),
                *([one["depth"] or None] if hardened else []),
                *(one[f"nominal_{name}"] for name in ("bending", "torsion")),
                *(one[name] for name in ("bending", "torsion")),
                one["added"] or None,
                *(one[name] for name in ("equivalent", "strength", "acceptability")),
            ]
            for one in places
        ],
        marks=["" if one["passed"] else "over" for one in places],
    )


def torque_table(record: Record) -> Table:
    """Return the largest alternating torque of each throw, with its speed and misfiring cylinders."""
    return Table(
        "Largest alternating torque",
        [
            Column("throw"),
            Column("torque", "kN m", missing=UNBOUNDED),
            Column("at", "1/min"),
            Column("misfiring cylinder"),
        ],
        [
            [
                one["throw"],
                one["alternating_torque"],
                one["torque_speed_rpm"] / RPM,
                one["misfiring"] or None,
            ]
            for one in record["throws"]
        ],
    )


def factor_table(record: Record) -> Table:
    """Return the factors of stress concentration of each web, those of equal webs once."""
    rows: dict[tuple[str, tuple[float | None, ...]], list[str]] = {}
    for throw in record["throws"]:
        for name, own in throw["webs"].items():
            for way, key in (("formulas", "factors"), ("finite elements", "finite_elements")):
                if own.get(key) is not None:
                    values = tuple(
                        None if own[key][one] is None else round(own[key][one], EQUAL)
                        for one in FACTORS
                    )
                    web = f"{throw['throw']} {name.removesuffix(' web')}"
                    rows.setdefault((way, values), []).append(web)
    ways = [way for way, _ in rows]
    both = len(set(ways)) > 1
    return Table(
        "Factors of stress concentration",
        [
            Column("webs", words=True),
            *([Column("by", words=True)] if both else []),
            *(Column(symbol, decimals=3) for symbol in SYMBOLS.values()),
        ],
        [
            ["all" if ways.count(way) == 1 else ", ".join(webs), *([way] if both else []), *values]
            for (way, values), webs in rows.items()
        ],
    )
