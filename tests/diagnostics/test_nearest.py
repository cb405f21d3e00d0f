"""The name that was probably meant."""

from __future__ import annotations

import pytest

from cbdsl.diagnostics.errors import UsageError
from cbdsl.diagnostics.nearest import suggestion


@pytest.mark.parametrize(
    ("name", "told"), [("serch", "; did you mean 'search'?"), ("grasp", ""), ("", "")]
)
def test_suggestion_contains_only_similar_names(name: str, told: str) -> None:
    assert suggestion(name, ["track", "search"]) == told


def test_unknown_name_is_reported_with_all_known_ones() -> None:
    error = UsageError.unknown("stage", "tabel", ["table", "wall"])
    assert str(error) == "unknown stage 'tabel'; did you mean 'table'? (known: table, wall)"
    assert str(UsageError.unknown("stage", "x", ())) == "unknown stage 'x' (known: none)"
