"""Unquoted scalars: the fast path for numbers gives the result of the patterns."""

from __future__ import annotations

import re

import pytest
from hypothesis import given
from hypothesis import strategies as st

from cbdsl.yaml_text import scalar
from cbdsl.yaml_text.scalar import ScalarError, resolve

TEXTS = st.text("+-.0123456789eE_:x", max_size=12) | st.decimals(
    allow_nan=False, allow_infinity=False
).map(str)


def meaning(text: str) -> object:
    """Return the type and the value, or the code of the error."""
    try:
        value = resolve(text)
    except ScalarError as error:
        return error.code
    return type(value), value


@given(TEXTS)
def test_simple_numbers_are_no_exception(text: str) -> None:
    quick = meaning(text)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(scalar, "_SIMPLE", re.compile("(?!)"))  # matches nothing
        assert meaning(text) == quick
