"""A compliance model compiled for queries: equations, bands, and fast evaluators."""

from collections.abc import Callable, Mapping
from functools import cached_property
from typing import Any

from crankbase.errors import InputError
from regression.models.error_band import error_band
from regression.models.family import Family
from regression.models.family_throw import angle_law_remarks
from regression.models.response_model import IS, ResponseModel
from regression.models.response_query import ResponseQuery, make_response_query

# Short ways are kept for so many different sets of names.
_MOST_WAYS = 1000


class CompiledModel:
    """What a model computes once for all its queries.

    Parameters
    ----------
    responses : mapping of str to ResponseModel
    family : Family
    material : mapping
    constant_groups : mapping
    throw : mapping or None
        The throw that the study varied, as a record.

    Attributes
    ----------
    family : Family
    bands : dict of str to ErrorBand

    Raises
    ------
    InputError
        If a column is none of the family's factors.
    """

    def __init__(
        self,
        responses: Mapping[str, ResponseModel],
        family: Family,
        material: Mapping[str, Any],
        constant_groups: Mapping[str, float],
        throw: Mapping[str, Any] | None,
    ) -> None:
        self.family = family
        self._throw = throw
        self.bands = {name: error_band(name, response) for name, response in responses.items()}
        self._questions = {
            name: make_response_query(name, response, family, material, constant_groups)
            for name, response in responses.items()
        }
        self._ways: dict[tuple[str, ...], Callable[[Mapping[str, Any]], float | None]] = {}

    @cached_property
    def angle_law_remarks(self) -> tuple[str, ...]:
        """What is to be known of the angle law of the model's throws."""
        return angle_law_remarks(self.family, self._throw)

    def query(self, name: str) -> ResponseQuery:
        """Return the query for a response, or say which there are."""
        if name not in self._questions:
            raise InputError(
                f"response: given {name!r}; allowed are {', '.join(self._questions)}, which this "
                "model holds."
            )
        return self._questions[name]

    def fast_lookup(self, name: str, dimensions: Mapping[str, Any]) -> float | None:
        """Look a value up by the fast evaluator; None where the full evaluation is needed."""
        key = (name, *dimensions)
        way = self._ways.get(key)
        if way is None:
            if len(self._ways) >= _MOST_WAYS:
                self._ways.clear()
            way = self._ways[key] = self.query(name).fast_evaluator(tuple(dimensions))
        return way(dimensions)


def column_ranges(responses: Mapping[str, ResponseModel]) -> dict[str, tuple[float, float]]:
    """Ranges of a model's numbers as the equations' columns have them."""
    ranges: dict[str, tuple[float, float]] = {}
    for response in responses.values():
        columns = zip(response.factors, response.lowest, response.highest, strict=True)
        for name, low, high in columns:
            if response.basis == "factors" and IS not in name:
                ranges.setdefault(name, (low, high))
    return ranges
