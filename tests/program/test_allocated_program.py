"""Background postures of programs with several allocations."""

from __future__ import annotations

from collections.abc import Sequence

import pytest

from cbdsl.api.load import load
from cbdsl.program.allocated_program import _joined
from cbdsl.program.controller import Composition, Primitive
from cbdsl.yaml_text.library import shipped


def background(order: Sequence[str]) -> Composition:
    return Composition(tuple(Primitive(name, ()) for name in order))


@pytest.mark.parametrize(
    ("backgrounds", "expected"),
    [
        (["ab"], "ab"),
        (["ab", "cd"], "cdab"),
        # A shared primitive has the priority of the first background that has it.
        (["as", "bs"], "bas"),
        (["sa", "sb"], "bsa"),
        (["a", "sb", "sc"], "csba"),
    ],
)
def test_joined_backgrounds_keep_the_priorities_of_the_first(
    backgrounds: list[str], expected: str
) -> None:
    joined = _joined([background(order) for order in backgrounds])
    assert joined is not None
    assert [primitive.name for primitive in joined.primitives] == list(expected)
    # The first background is the most important part, in its own order.
    assert [p.name for p in joined.primitives[-len(backgrounds[0]) :]] == list(backgrounds[0])


def test_shipped_schema_keeps_the_background_of_its_first_allocation() -> None:
    schema = shipped() / "knowledge" / "schemas" / "pick_and_place.yaml"
    joined = load("pick_and_place", schema=schema).program.background
    assert joined is not None
    names = [(each.name, each.lead.effector.name) for each in joined.primitives]
    assert names[-3:] == [("search", "head"), ("watch", "head"), ("hold", "right_hand")]
