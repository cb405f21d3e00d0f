"""Tests of the spelling of roles."""

import pytest

from cbdsl.types.allotment import ALLOTMENTS, EFFECTOR
from cbdsl.types.role import role


@pytest.mark.parametrize("kind", [k for k, each in ALLOTMENTS.items() if each.kind == EFFECTOR])
def test_role_of_each_kind_of_effector_reads_its_relations(kind: str) -> None:
    plain, related = role(kind, {}), role(f"{kind} on  arm\n other than hand", {})
    assert plain is not None and plain.relations == {}
    assert related is not None and related.wanted == ALLOTMENTS[kind]
    assert related.relations == {"on": "arm", "other than": "hand"}
    assert role("hand other than hand", {"hand": related}) == related._replace(on="", other="hand")


@pytest.mark.parametrize(
    "text",
    [
        "effector",
        "effector of color",
        "effector of force at arm",
        "effector of force on",
        "heading channel",
        "program of force",
        "on arm",
    ],
)
def test_role_of_another_spelling_is_none(text: str) -> None:
    assert role(text, {}) is None
