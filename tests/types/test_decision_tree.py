"""Decision trees answer by thresholds, and give no answer for unknown features."""

from __future__ import annotations

import math

from hypothesis import given
from hypothesis import strategies as st

from cbdsl.types.decision_tree import Leaf, Split, decide, leaves, splits

TREE = Split("y", 0.1, Leaf("left"), Split("x", 1.0, Leaf("none"), Leaf("right")))


@given(st.floats(-2, 2), st.floats(-2, 2))
def test_tree_decides_by_its_nested_conditions(x: float, y: float) -> None:
    expected = "left" if y > 0.1 else "none" if x > 1.0 else "right"
    assert decide(TREE, {"x": x, "y": y}) == expected


def test_feature_without_a_question_may_be_unknown() -> None:
    assert decide(TREE, {"y": 0.2}) == "left"
    assert decide(TREE, {"y": 0.2, "x": math.nan}) == "left"
    assert decide(TREE, {"y": 0.0}) is None
    assert decide(TREE, {"y": math.nan, "x": 0.0}) is None


def test_splits_and_leaves_list_all_questions_and_answers() -> None:
    assert [(split.feature, split.threshold) for split in splits(TREE)] == [("y", 0.1), ("x", 1.0)]
    assert list(leaves(TREE)) == ["left", "none", "right"]
