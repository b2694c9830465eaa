"""Show the reference how models of input and results are called: with the fields that they declare."""

from collections.abc import Iterator
from typing import Any

import griffe

BASE = "InputModel"


class InputModels(griffe.Extension):
    """Gives such classes the constructor that they get when the program runs."""

    def on_package(self, *, pkg: griffe.Module, **_: Any) -> None:
        """Add constructors, once a package is read whole, so that bases in other modules are known."""
        for cls in list(_classes(pkg)):
            model = any(str(base) == BASE for one in (cls, *_bases(cls)) for base in one.bases)
            if model or any(str(one.value).startswith("result(") for one in cls.decorators):
                this = griffe.Parameter("self", kind=griffe.ParameterKind.positional_or_keyword)
                made = griffe.Function(
                    "__init__", parameters=griffe.Parameters(this, *_fields(cls))
                )
                cls.set_member("__init__", made)


def _classes(module: griffe.Module) -> Iterator[griffe.Class]:
    """Yield the classes of a module and of the modules in it."""
    for member in module.members.values():
        if isinstance(member, griffe.Module):
            yield from _classes(member)
        elif isinstance(member, griffe.Class):
            yield member


def _bases(cls: griffe.Class) -> list[griffe.Class]:
    """Return the bases that are known, the farthest first; `InputModel` itself has no fields."""
    return [
        base for base in reversed(cls.mro()) if isinstance(base, griffe.Class) and base.name != BASE
    ]


def _fields(cls: griffe.Class) -> list[griffe.Parameter]:
    """Return the fields of a class, after those of its bases."""
    found = {
        name: griffe.Parameter(
            name,
            annotation=member.annotation,
            kind=griffe.ParameterKind.keyword_only,
            default=_default(member.value),
        )
        for one in (*_bases(cls), cls)
        for name, member in one.members.items()
        if isinstance(member, griffe.Attribute)
        and member.labels & {"class-attribute", "instance-attribute"}
        and "ClassVar" not in str(member.annotation)
        and "property" not in member.labels
        and name not in {"section", "model_config"}
        and not name.startswith("_")
        and member.annotation is not None
    }
    return list(found.values())


def _default(value: Any) -> Any:
    """Return what stands in the place of a field that is not given; None where it must be."""
    if not isinstance(value, griffe.ExprCall):
        return value
    first = value.arguments[0] if value.arguments else None
    if str(value.function) == "Field" and not isinstance(first, griffe.ExprKeyword):
        return first
    given = {one.name: one.value for one in value.arguments if isinstance(one, griffe.ExprKeyword)}
    if "default" in given:
        return given["default"]
    if "default_factory" in given:
        return f"{given['default_factory']}()"
    if str(value.function) == "part_field":
        return "()" if "many" in given else "None"
    return None
