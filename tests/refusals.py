"""Refused input: one sentence that names the field; how it is worded is in tests/snapshots."""

import re
from contextlib import contextmanager

import pytest

from crankbase.errors import InputError


@contextmanager
def refused(field=""):
    """Expect that input is refused by one sentence about this field, or about any."""
    with pytest.raises(InputError) as caught:
        yield caught
    sentence = str(caught.value)
    assert re.match(rf"(.*[:,] |/.*/)?{re.escape(field) or '[^;]+'}: .+; .+\.$", sentence), sentence


def refusals(*rows):
    """Return a test that each call is refused; rows are a field and a call."""

    @pytest.mark.parametrize(("field", "call"), rows)
    def test(field, call):
        with refused(field):
            call()

    return test


def refusals_of(call, *rows):
    """Return a test that a call is refused with each row of arguments, which ends with the field."""

    @pytest.mark.parametrize(("arguments", "field"), [(row[:-1], row[-1]) for row in rows])
    def test(arguments, field):
        with refused(field):
            call(*arguments)

    return test
