"""Finite elements of an engine's throws: each distinct one analyzed once, then crank by crank."""

from collections.abc import Mapping
from typing import TYPE_CHECKING, TypeAlias, Union

from crankbase.choices import check_kind
from crankbase.errors import InputError
from crankfem.files.engine.engine_file import EngineFile

if TYPE_CHECKING:
    from fem.analysis import ThrowAnalysis

# Of the one throw that all cranks are, or of each throw by its name.
Analyses: TypeAlias = Union["ThrowAnalysis", Mapping[str, "ThrowAnalysis"]]


def analyze_throws(engine_file: EngineFile) -> "dict[str, ThrowAnalysis]":
    """Analyze the distinct throws of an engine.

    Returns
    -------
    dict
        By their names, those of equal throws the same.

    Raises
    ------
    MeshError, SolveError
        If a throw cannot be meshed or solved.
    """
    from fem.analysis import analyze_throw  # here: engine files are checked without it

    throws = engine_file.named_throws
    analyses = {
        throw: analyze_throw(throw, engine_file.material)
        for throw in dict.fromkeys(throws.values())
    }
    return {name: analyses[throw] for name, throw in throws.items()}


def analyses_by_name(engine_file: EngineFile, analysis: Analyses) -> "dict[str, ThrowAnalysis]":
    """Return the analyses of an engine's throws by name.

    Raises
    ------
    InputError
        If one is missing, or there are others.
    """
    from fem.analysis import ThrowAnalysis

    names = tuple(engine_file.named_throws)
    for each in analysis.values() if isinstance(analysis, Mapping) else [analysis]:
        check_kind(
            "analysis", each, ThrowAnalysis, "what analyze_throw returns, or a mapping of these"
        )
    if isinstance(analysis, Mapping):
        if set(analysis) != set(names):
            raise InputError(
                f"analysis: given those of {', '.join(map(str, analysis)) or 'no throw'}; allowed are those "
                f"of {', '.join(names)}, because these are the engine's throws."
            )
        return {name: analysis[name] for name in names}
    if len(names) > 1:
        raise InputError(
            "analysis: given that of one throw; allowed is a mapping with those of "
            f"{', '.join(names)}, because the engine has these throws."
        )
    return {names[0]: analysis}


def crank_analyses(engine_file: EngineFile, analysis: Analyses) -> "tuple[ThrowAnalysis, ...]":
    """Return the analysis of each crank's throw, from the free end.

    Raises
    ------
    InputError
        If that of a throw is missing.
    """
    analyses = analyses_by_name(engine_file, analysis)
    return tuple(analyses[name] for name in engine_file.throw_names)
