"""The sections of engine files for limits of vibration and for uncertain values."""

import math
from collections.abc import Mapping
from dataclasses import replace
from typing import Any, ClassVar, Self

from pydantic import Field, model_validator

from crankbase.choices import check_choice
from crankbase.errors import InputError
from crankbase.model import InputModel, part_field, quantity_field
from crankbase.sentences import amount, in_si
from dynamics.assessment.barred_ranges import BarredRangeRule
from dynamics.assessment.limit_rules import CRANKSHAFT_RULES, SHAFT_FEATURES, propulsion_shaft_limit
from dynamics.assessment.limit_rules import Kind as EngineKind
from dynamics.assessment.limits import VibrationLimit, given_limit
from dynamics.assessment.uncertainty import Kind, Spread

# What each value given in [limits] applies to: quantity, place and SI unit.
GIVEN = {
    "crankshaft_stress": ("torsional stress", "crankshaft", "Pa"),
    "coupling_torque": ("torque", "coupling", "N m"),
    "torsional_amplitude": ("torsional amplitude", "free end", "rad"),
    "axial_amplitude": ("axial amplitude", "free end", "m"),
    "axial_force": ("axial force", "throws", "N"),
}
PASSING = "_passing"
# Where a value that has no source of its own comes from.
ENGINE_FILE = "given in the engine file"
Provenance = Mapping[str, tuple[str, bool]]


class ShaftLimitInput(InputModel):
    """A propulsion shaft whose stress is limited by the unified requirement M68."""

    section: ClassVar[str] = "limits.shafts"

    element: str = Field(
        description='element of the torsional chain, such as "flywheel - propeller"'
    )
    diameter: float = quantity_field("diameter of the shaft", "m", 0.01, 2.0)
    tensile_strength: float = quantity_field(
        "specified minimum tensile strength", "Pa", 4e8, 1.2e9, symbol="sigma_B"
    )
    feature: str = Field(
        "integral flange",
        description=f"weakest feature, which sets the factor c_K: {', '.join(SHAFT_FEATURES)}",
    )
    alloy: bool = Field(False, description="whether the steel is low-alloy")

    @model_validator(mode="after")
    def _known(self) -> Self:
        why = "the rule gives a factor for these"
        check_choice("limits.shafts.feature", self.feature, SHAFT_FEATURES, why)
        return self

    def limit(self, rated_speed: float) -> VibrationLimit:
        """Return the limit of the shaft's stress, with its speed at the rated one [rad/s]."""
        return propulsion_shaft_limit(
            self.tensile_strength,
            self.diameter,
            rated_speed,
            feature=self.feature,
            alloy=self.alloy,
            applies_to=self.element,
        )


class ElementLimitInput(InputModel):
    """A coupling or damper of a shaft line, and what its maker permits."""

    section: ClassVar[str] = "limits.elements"

    element: str = Field(
        description='element or dashpot of the torsional chain, such as "gear - generator"'
    )
    torque: float | None = quantity_field(
        "permissible vibratory torque", "N m", 1e-2, 1e9, default=None
    )
    torque_passing: float | None = quantity_field(
        "the same while passing a barred speed range", "N m", 1e-2, 1e9, default=None
    )
    heat: float | None = quantity_field(
        "permissible heat, for the class document", "W", 1e-3, 1e9, default=None
    )

    @model_validator(mode="after")
    def _limits_something(self) -> Self:
        if self.torque is None and self.heat is None:
            raise InputError(
                "limits.elements.torque: given neither it nor heat; allowed is one of them or both, because "
                "the part is limited by them."
            )
        check_passing("limits.elements", "torque", self.torque, self.torque_passing, "N m")
        return self


def check_passing(
    section: str, name: str, kept: float | None, passing: float | None, unit: str
) -> None:
    """Refuse a permitted value for passing a barred range below that for continuous running."""
    if passing is not None and (kept is None or passing < kept):
        raise InputError(
            f"{section}.{name}{PASSING}: given {in_si(passing, unit)}; allowed is no less than {name}, "
            "which must be given, because a permitted continuous vibration may also be passed."
        )


class LimitsInput(InputModel):
    """Permitted amplitudes: half of the range from lowest to highest value."""

    section: ClassVar[str] = "limits"
    # Beyond the strengths that carbon steel may have, the rule asks for the alloy.
    choices = frozenset({"crankshaft_rule", "alloy", "passing_while_misfiring"})

    crankshaft_stress: float | None = quantity_field(
        "permissible nominal torsional vibration stress of the crankshaft",
        "Pa",
        minimum=1e5,
        maximum=1e9,
        default=None,
    )
    crankshaft_stress_passing: float | None = quantity_field(
        "the same while passing a barred speed range", "Pa", 1e5, 1e9, default=None
    )
    coupling_torque: float | None = quantity_field(
        "permissible vibratory torque of the coupling behind the flywheel",
        "N m",
        minimum=1e-2,
        maximum=1e9,
        default=None,
    )
    coupling_torque_passing: float | None = quantity_field(
        "the same while passing a barred speed range", "N m", 1e-2, 1e9, default=None
    )
    coupling_heat: float | None = quantity_field(
        "permissible heat of that coupling, for the class document", "W", 1e-3, 1e9, default=None
    )
    damper_torque: float | None = quantity_field(
        "permissible vibratory torque of the torsional damper, for the class document",
        "N m",
        minimum=1e-2,
        maximum=1e9,
        default=None,
    )
    damper_heat: float | None = quantity_field(
        "permissible heat of the torsional damper, for the class document",
        "W",
        minimum=1e-3,
        maximum=1e9,
        default=None,
    )
    generator_angle: float | None = quantity_field(
        "permissible amplitude of the generator's rotor, electrical angle, for the class document",
        "rad",
        minimum=math.radians(1e-3),
        maximum=math.radians(90.0),
        default=None,
    )
    torsional_amplitude: float | None = quantity_field(
        "permissible torsional vibration amplitude of the free end",
        "rad",
        minimum=math.radians(1e-4),
        maximum=math.radians(60.0),
        default=None,
    )
    axial_amplitude: float | None = quantity_field(
        "permissible axial vibration amplitude of the free end", "m", 1e-7, 1e-1, default=None
    )
    axial_force: float | None = quantity_field(
        "permissible vibratory axial force through the throws", "N", 1.0, 1e9, default=None
    )
    crankshaft_rule: str = Field(
        "",
        description="rule for the crankshaft's limit if the maker gives none: "
        f"{' or '.join(CRANKSHAFT_RULES)}",
    )
    tensile_strength: float | None = quantity_field(
        "specified minimum tensile strength of the crankshaft, for the rule",
        "Pa",
        minimum=1e8,
        maximum=2e9,
        default=None,
    )
    yield_strength: float | None = quantity_field(
        "specified minimum yield strength of the crankshaft, for the rule",
        "Pa",
        minimum=1e8,
        maximum=2e9,
        default=None,
    )
    alloy: bool = Field(False, description="whether the crankshaft is of low alloy steel")
    highest_barred: float | None = quantity_field(
        "share of the rated speed above which no speed range may be barred; by default that of each limit, "
        "otherwise 0.8",
        "",
        minimum=0.1,
        maximum=1.0,
        default=None,
    )
    passing_while_misfiring: bool = Field(
        False,
        description="whether the limits for passing serve while a cylinder misfires, where the class or the "
        "maker says so; by default those of continuous running",
    )
    shafts: tuple[ShaftLimitInput, ...] = part_field(
        "propulsion shafts limited by the unified requirement M68", ShaftLimitInput, many=True
    )
    elements: tuple[ElementLimitInput, ...] = part_field(
        "couplings and dampers of a shaft line", ElementLimitInput, many=True
    )

    @model_validator(mode="after")
    def _fits_together(self) -> Self:
        for table in ("shafts", "elements"):
            names = [part.element for part in getattr(self, table)]
            for place, element in enumerate(names):
                if element in names[:place]:
                    raise InputError(
                        f"limits.{table}[{place}].element: given {element!r} a second time; allowed is each "
                        "element once, because it has one limit."
                    )
        tensile, yielding = self.tensile_strength, self.yield_strength
        if tensile is not None and yielding is not None and yielding > tensile:
            raise InputError(
                f"limits.yield_strength: given {amount(yielding, 'Pa')} above a tensile_strength of "
                f"{amount(tensile, 'Pa')}; allowed is that or less, because a steel yields before "
                "it breaks."
            )
        if self.crankshaft_rule:
            why = "their formulas are known"
            check_choice("limits.crankshaft_rule", self.crankshaft_rule, CRANKSHAFT_RULES, why)
        if self.crankshaft_rule and self.crankshaft_stress is not None:
            raise InputError(
                f"limits.crankshaft_rule: given {self.crankshaft_rule!r} together with crankshaft_stress; "
                "allowed is one of them, because the maker's value replaces the rule's."
            )
        if self.crankshaft_rule and (self.tensile_strength is None or self.yield_strength is None):
            raise InputError(
                f"limits.crankshaft_rule: given {self.crankshaft_rule!r} without tensile_strength "
                "and yield_strength; allowed is the rule with both, because it depends on them."
            )
        for name, (_, _, unit) in GIVEN.items():
            passing = getattr(self, name + PASSING, None)
            check_passing("limits", name, getattr(self, name), passing, unit)
        return self

    def limits(
        self,
        rated_speed: float,
        *,
        strokes: int,
        kind: EngineKind = "in line",
        firing_interval_deg: float | None = None,
        provenance: Provenance | None = None,
    ) -> dict[str, VibrationLimit]:
        """Return all limits by the names of their fields; others as "shaft: ELEMENT", "torque: ELEMENT".

        Parameters
        ----------
        rated_speed : float
            [rad/s].
        strokes, kind, firing_interval_deg
            Of the engine, for the crankshaft's rule; see `crankshaft_limit`.
        provenance : mapping, optional
            Field, such as "limits.axial_amplitude", to its source and whether it is assumed.
        """
        sources = provenance or {}
        limits = {}
        for name, (quantity, place, unit) in GIVEN.items():
            value = getattr(self, name)
            if value is None:
                continue
            source, assumed = sources.get(f"limits.{name}", ("", False))
            limits[name] = given_limit(
                quantity,
                value,
                unit,
                applies_to=place,
                source=source.strip() or ENGINE_FILE,
                passing=getattr(self, name + PASSING, None),
                assumed=assumed,
            )
        if self.crankshaft_rule:
            by_rule = self._crankshaft_limit(
                rated_speed, strokes=strokes, kind=kind, firing_interval_deg=firing_interval_deg
            )
            _, assumed = sources.get("limits.crankshaft_rule", ("", False))
            limits["crankshaft_stress"] = replace(by_rule, assumed=assumed)
        for shaft in self.shafts:
            limits[f"shaft: {shaft.element}"] = shaft.limit(rated_speed)
        for number, part in enumerate(self.elements):
            if part.torque is not None:
                source, assumed = sources.get(f"limits.elements[{number}].torque", ("", False))
                limits[f"torque: {part.element}"] = given_limit(
                    "torque",
                    part.torque,
                    "N m",
                    applies_to=part.element,
                    source=source.strip() or ENGINE_FILE,
                    passing=part.torque_passing,
                    assumed=assumed,
                )
        return limits

    def _crankshaft_limit(self, rated_speed: float, **engine: Any) -> VibrationLimit:
        return CRANKSHAFT_RULES[self.crankshaft_rule](
            rated_speed,
            tensile_strength=self.tensile_strength,
            yield_strength=self.yield_strength,
            alloy=self.alloy,
            **engine,
        )

    def barred_rule(self, rated_speed: float) -> BarredRangeRule:
        """Return the width of barred ranges about critical speeds, and their upper end [rad/s]."""
        return BarredRangeRule(rated_speed, self.highest_barred)


def _factors(meaning: str) -> tuple[float, float] | None:
    field: tuple[float, float] | None = quantity_field(
        f"least and largest factor on {meaning}", "", default=None
    )
    return field


class RangesInput(InputModel):
    """Uncertain values: for each a least and a largest factor, such as [0.95, 1.10]."""

    section: ClassVar[str] = "ranges"
    choices = frozenset({"samples", "seed", "separation_margin"})

    axial_compliance: tuple[float, float] | None = _factors("the throws' axial compliance")
    torsional_compliance: tuple[float, float] | None = _factors("the throws' torsional compliance")
    mass: tuple[float, float] | None = _factors("the masses of the axial chain")
    inertia: tuple[float, float] | None = _factors("the inertias of the torsional chain")
    thrust_stiffness: tuple[float, float] | None = _factors("the thrust bearing's stiffness")
    damping: tuple[float, float] | None = _factors("all damping")
    samples: int = quantity_field("number of samples of amplitudes", "", 2, 100_000, default=200)
    seed: int = quantity_field(
        "seed of the samples; the same seed gives the same samples", "", 0, 2**31, default=0
    )
    separation_margin: float = quantity_field(
        "margin that critical speeds should keep from running speeds, as a share",
        "",
        minimum=0.0,
        maximum=1.0,
        default=0.10,
    )

    @model_validator(mode="after")
    def _possible(self) -> Self:
        for name, factors in self:
            if isinstance(factors, tuple) and not 0.0 < factors[0] <= 1.0 <= factors[1]:
                raise InputError(
                    f"ranges.{name}: given {list(factors)}; allowed are a low factor above 0 up to 1 "
                    "and a high one from 1, because the nominal value is possible too."
                )
        return self

    def axial_spreads(self) -> tuple[Spread, ...]:
        """Return the spreads of the axial chain; only the thrust bearing holds it to ground."""
        return _spreads(
            ("compliance", self.axial_compliance, "axial compliance"),
            ("inertia", self.mass, "mass"),
            ("ground stiffness", self.thrust_stiffness, "thrust bearing"),
            ("all damping", self.damping, "damping"),
        )

    def torsional_spreads(
        self, elements: tuple[int | str, ...] | None = None
    ) -> tuple[Spread, ...]:
        """Return the spreads of the torsional chain; compliances of all elements, or of those given."""
        compliance = _spreads(
            ("compliance", self.torsional_compliance, "torsional compliance"), places=elements
        )
        return compliance + _spreads(
            ("inertia", self.inertia, "inertia"), ("all damping", self.damping, "damping")
        )


def _spreads(
    *spreads: tuple[Kind, tuple[float, float] | None, str],
    places: tuple[int | str, ...] | None = None,
) -> tuple[Spread, ...]:
    return tuple(
        Spread(kind, *factors, places=places, name=name)
        for kind, factors, name in spreads
        if factors is not None
    )
