"""Trees, judged by their answers in contexts outside of their training set."""

from __future__ import annotations

from pathlib import Path

import pytest

from cbdsl.types.decision_tree import Leaf, Split, Tree
from cbdsl_reproduction.chapter_5 import schema_trees
from cbdsl_reproduction.chapter_5.schema_trees import Question, Trees, quantities
from cbdsl_reproduction.experiment import RunSettings
from cbdsl_reproduction.quantity import Verdict

SIDES: Tree[tuple[str, ...]] = Split("place.y", 0.0, Leaf(("left_arm",)), Leaf(("right_arm",)))
GOOD = Trees(
    Split("volume", 0.01, Leaf(("reachtouch_bimanual",)), SIDES),
    Split("place.x", 1.0, Leaf(0.02), Leaf(0.98)),
)
BAD = Trees(Leaf(("right_arm",)), Leaf(0.6))
ASKED = [
    Question("large", {"place.x": 0.6, "place.y": 0.0, "volume": 0.02}),
    Question("left", {"place.x": 0.6, "place.y": 0.6, "volume": 0.002}),
    Question("right", {"place.x": 0.6, "place.y": -0.6, "volume": 0.002}),
    Question("far", {"place.x": 1.5, "place.y": 0.1, "volume": 0.002}),
]


def test_sources_trees_are_reproduced() -> None:
    rows = list(quantities([GOOD] * 10, ASKED, 0))
    *judged, reach = rows
    assert {row.verdict for row in judged} == {Verdict.REPRODUCED}
    assert reach.verdict is Verdict.NOT_JUDGED, "no such tree could fail"
    assert rows[-1].ours == 1.0


def test_trees_with_one_arm_and_without_a_limit_of_reach_are_missed() -> None:
    large, left, right, far, near, first = quantities([BAD] * 10, ASKED, 0)
    missed = [each.verdict is Verdict.MISSED for each in (large, left, far, first)]
    assert all(missed)
    assert right.verdict is near.verdict is Verdict.REPRODUCED


@pytest.mark.slow
def test_experiment_resumes_from_kept_trials(tmp_path: Path) -> None:
    # Some of its ten episodes are out of reach, so that the tree has a question to draw.
    settings = RunSettings(seed=5330200, quick=True, folder=tmp_path)
    result = schema_trees.run(settings)
    assert len(result.quantities) >= 6
    (picture,) = result.charts
    assert "place.x" in picture.svg()
    (kept,) = tmp_path.iterdir()
    written = kept.stat().st_mtime_ns
    # Some are NaN, which is unequal to itself.
    assert repr(schema_trees.run(settings).quantities) == repr(result.quantities)
    assert kept.stat().st_mtime_ns == written
