"""Public names of a package: declared once in its stub, loaded from their modules on first use."""

import sys
from collections.abc import Callable
from functools import cache
from importlib import import_module
from pathlib import Path
from typing import Any


def lazy_exports(package: str, file: str) -> tuple[Callable[[str], Any], Callable[[], list[str]]]:
    """Return a package's `__getattr__` and `__dir__`, which load the imports of its stub lazily.

    A stub is for type checkers; reading the names from it at run time keeps the two the same.

    Parameters
    ----------
    package : str
        The package's `__name__`. What its stub imports from the package itself are its subpackages.
    file : str
        The package's `__file__`.

    Returns
    -------
    tuple of callable
        `__getattr__`, which also knows `__all__`, and `__dir__`, which tells the names of the stub alone.
    """

    @cache
    def source_modules() -> dict[str, tuple[str, str]]:
        import ast

        stub = ast.parse(Path(file).with_suffix(".pyi").read_text(encoding="utf-8"))
        return {
            alias.asname or alias.name: (str(statement.module), alias.name)
            for statement in stub.body
            if isinstance(statement, ast.ImportFrom)
            for alias in statement.names
        }

    def getattr_(name: str) -> Any:
        if name == "__all__":
            return sorted(source_modules())
        # Python asks for names of its own, such as __path__; the stub is not read for them.
        if name.startswith("__") or name not in source_modules():
            raise AttributeError(f"module {package!r} has no attribute {name!r}")
        home, name_there = source_modules()[name]
        if home == package:
            return import_module(f"{package}.{name_there}")
        value = getattr(import_module(home), name_there)
        setattr(sys.modules[package], name, value)
        return value

    def dir_() -> list[str]:
        dunders = {name for name in vars(sys.modules[package]) if name.startswith("__")}
        return sorted(dunders | set(source_modules()))

    return getattr_, dir_
