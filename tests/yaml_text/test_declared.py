"""Sections with omitted entries."""

from __future__ import annotations

import pytest

from cbdsl.diagnostics.outcome import UNKNOWN
from cbdsl.yaml_text.broken import Broken
from cbdsl.yaml_text.declared import Declared


def test_broken_entry_is_declared_and_unknown() -> None:
    declared = Declared({"arm": 1}, Broken([("effectors", "head")]), ("effectors",))
    assert declared["arm"] == 1 and list(declared) == ["arm"]
    assert "head" in declared and declared["head"] is UNKNOWN
    assert "leg" not in declared
    with pytest.raises(KeyError, match="leg"):
        declared["leg"]


def test_every_name_of_a_broken_section_is_unknown() -> None:
    declared: Declared[int] = Declared({}, Broken([("effectors",)]), ("effectors",))
    assert declared["leg"] is UNKNOWN and len(declared) == 0


def test_further_entries_hide_those_of_the_same_name() -> None:
    declared = Declared({"arm": 1}, Broken([("effectors", "head")]), ("effectors",))
    extended = declared.extended({"arm": 2, "head": 3})
    assert dict(extended) == {"arm": 2, "head": 3} and declared["head"] is UNKNOWN
