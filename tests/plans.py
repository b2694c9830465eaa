"""Plans of studies, as tests write them, and their tables with functions in place of finite elements."""

from dataclasses import replace

import numpy as np

from parts_in_a_line import crank_throw
from regression.plans.factors import Factor, throw_fields
from regression.plans.plan import StudyPlan, planned_design
from regression.records import RUN, Outcome
from regression.runs.study_table import study_table

# A throw whose mesh is small.
SHARP = crank_throw(0.170, 0.220, 0.180, 0.120, 0.139, 0.285, 0.068)
# The same with fillets.
FILLETED = SHARP.changed(fillet_radius=0.012)


def plan_of_levels(throw, levels, **others):
    """Return a full factorial over levels [SI] of fields of the throw."""
    fields = throw_fields(throw)
    factors = tuple(
        Factor.of_levels(name, fields[name].unit, values) for name, values in levels.items()
    )
    return StudyPlan(throw, factors, **others)


def table_of_function(plan, function, further=None):
    """Return the table of a study whose axial compliance is a function of the factors.

    `further` runs (n, k) are added to those of the plan.
    """
    designs = list(plan.planned.designs)
    if further is not None:
        made = plan.variants().at(further)
        designs += [
            replace(planned_design(plan, RUN, tuple(row), one.throw), added=True)
            for row, one in zip(further.tolist(), made, strict=True)
        ]
    values = function(np.array([design.values for design in designs]))
    name = "axial_compliance_pinned"
    outcomes = {
        design.key: Outcome(
            design.key, design.inputs, {name: value}, None, 0.0, errors={name: 0.005}
        )
        for design, value in zip(designs, values.tolist(), strict=True)
    }
    return study_table(plan, designs, outcomes)
