"""Show the reference how models of input are called: with the fields that they declare."""

from typing import Any

import griffe

BASE = "InputModel"


class InputModels(griffe.Extension):
    """Gives such classes the constructor that pydantic gives them when the program runs."""

    def on_class_members(self, *, cls: griffe.Class, **_: Any) -> None:
        """Add the constructor of a class made from the base of all input."""
        if not any(str(base) == BASE for base in cls.bases):
            return
        fields = [
            griffe.Parameter(
                name,
                annotation=member.annotation,
                kind=griffe.ParameterKind.keyword_only,
                default=_default(member.value),
            )
            for name, member in cls.members.items()
            if isinstance(member, griffe.Attribute)
            and "class-attribute" in member.labels
            and name not in {"section", "model_config"}
            and not name.startswith("_")
            and member.annotation is not None
        ]
        this = griffe.Parameter("self", kind=griffe.ParameterKind.positional_or_keyword)
        made = griffe.Function("__init__", parameters=griffe.Parameters(this, *fields))
        cls.set_member("__init__", made)


def _default(value: Any) -> Any:
    """Return what stands in the place of a field that is not given; None where it must be."""
    if not isinstance(value, griffe.ExprCall):
        return value
    given = {one.name: one.value for one in value.arguments if isinstance(one, griffe.ExprKeyword)}
    if "default" in given:
        return given["default"]
    if "default_factory" in given:
        return f"{given['default_factory']}()"
    if str(value.function) == "part_field":
        return "()" if "many" in given else "None"
    return None
