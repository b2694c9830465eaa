"""What a study would compute, as a table for people and as a record for machines."""

from typing import Any

from crankfem import console
from crankfem.console import print_table
from geometry.quantity import DISPLAY_UNITS
from regression.plans.factors import Factor
from regression.plans.plan import PlannedStudy
from regression.records import HELD_OUT


def plan_record(planned: PlannedStudy) -> dict[str, Any]:
    """Return the designs of a study as JSON content: SI units, choices by their labels."""
    factors = planned.plan.factors
    return {
        "study": planned.plan.key,
        "statement": planned.statement,
        "remarks": list(planned.remarks),
        "factors": [
            {"name": factor.name, "unit": factor.unit, "labels": list(factor.labels)}
            for factor in factors
        ],
        "designs": [
            {"role": design.role, "key": design.key, "values": _named(factors, design.values)}
            for design in planned.designs
        ],
        "excluded": [
            {
                "role": design.role,
                "values": _named(factors, design.values),
                "reason": design.reason,
            }
            for design in planned.excluded
        ],
    }


def print_plan(planned: PlannedStudy) -> None:
    """Print the designs of a study, what they are called, and which were excluded and why."""
    plan = planned.plan
    held_out = sum(design.role == HELD_OUT for design in planned.designs)
    _say(
        f"{planned.statement[0].upper()}{planned.statement[1:]}; {held_out} held-out designs to judge by "
        f"(Latin hypercube, seed {plan.seed})."
    )
    for remark in planned.remarks:
        _say(f"Note: {remark}")
    print_table(
        "Designs",
        ["design", "role:", *(_heading(factor) for factor in plan.factors)],
        [
            [str(number), design.role, *map(_cell, plan.factors, design.values)]
            for number, design in enumerate(planned.designs, start=1)
        ],
    )
    for path, text in plan.relations.items():
        _say(f"In every design {path} = {text}.")
    if planned.excluded:
        print_table(
            "Excluded designs",
            ["role", *(_heading(factor) for factor in plan.factors), "reason:"],
            [
                [design.role, *map(_cell, plan.factors, design.values), design.reason]
                for design in planned.excluded
            ],
        )


def _say(text: str) -> None:
    console.output.print(text, soft_wrap=True, highlight=False)


def _heading(factor: Factor) -> str:
    if factor.categorical:
        return f"{factor.name}:"
    return f"{factor.name} [{DISPLAY_UNITS.get(factor.unit, (factor.unit, 1.0))[0]}]".removesuffix(
        " []"
    )


def _cell(factor: Factor, value: float) -> str:
    if factor.categorical:
        return factor.show(value)
    return f"{value / DISPLAY_UNITS.get(factor.unit, ('', 1.0))[1]:.6g}"


def _named(factors: tuple[Factor, ...], values: tuple[float, ...]) -> dict[str, float | str]:
    return {
        factor.name: factor.show(value) if factor.categorical else value
        for factor, value in zip(factors, values, strict=True)
    }
