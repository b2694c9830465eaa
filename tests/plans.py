"""Plans of studies, as tests write them."""

from regression.plans.factors import Factor, throw_fields
from regression.plans.plan import StudyPlan


def plan_of_levels(throw, levels, **others):
    """Return a full factorial over levels [SI] of fields of the throw."""
    fields = throw_fields(throw)
    factors = tuple(
        Factor.of_levels(name, fields[name].unit, values) for name, values in levels.items()
    )
    return StudyPlan(throw, factors, **others)
