"""Hand transfers: counted if chosen first, and earning if they alone led to the reward."""

from __future__ import annotations

from pathlib import Path

import pytest

from cbdsl.documents.schema import SchemaDocument
from cbdsl.learning.experience import Experience
from cbdsl.program.transition import Transition
from cbdsl_reproduction.chapter_7 import hand_transfer
from cbdsl_reproduction.chapter_7.hand_transfer import AssimilatedTrial, quantities
from cbdsl_reproduction.experiment import RunSettings
from cbdsl_reproduction.quantity import Verdict

SCHEMA = SchemaDocument.model_validate(
    {
        "cbdsl": 1,
        "kind": "schema",
        "name": "pick_and_place",
        "program": "pick_and_place",
        "policy": "pick_and_place",
        "features": {"goal_place": "stereo.$goal"},
        "allocations": {
            "right_arm": {"arm": "right_arm", "hand": "right_hand"},
            "left_arm_handover": {
                "arm": "left_arm",
                "hand": "left_hand",
                "reachtouch": "handover",
            },
        },
        "choose": "right_arm",
        "otherwise": ["right_arm"],
    }
)


def episode(context: str, *steps: tuple[str, int]) -> Experience:
    """Return an episode of one transition for each allocation, with its reward."""
    transitions = tuple(
        Transition("pick_and_place", 0, 1.0, "XXX", "reachtouch", "0XX", 60, reward, (), name)
        for name, reward in steps
    )
    return Experience(context, 0, transitions, {}, 60, 1.0)


def trial(far: Experience, dip: bool = True) -> AssimilatedTrial:
    good = episode("right", ("right_arm", 1))
    poor = episode("right", ("left_arm_handover", 0), ("right_arm", 0), ("right_arm", 1))
    learned = (good,) * 10 + ((poor,) * 6 if dip else ()) + (good,) * 14
    return AssimilatedTrial(learned, 10, (far, good), SCHEMA)


HANDED = episode("across", ("left_arm_handover", 1))


def test_dip_that_ends_and_a_transfer_that_works_are_reproduced() -> None:
    rows = list(quantities([trial(HANDED)] * 10, 0))
    assert [each.verdict for each in rows] == [Verdict.REPRODUCED] * len(rows)
    dip, length, chosen, placed, _ = rows
    assert dip.ours < 0 < length.ours < 20
    assert chosen.ours == placed.ours == 100.0


@pytest.mark.parametrize(
    ("far", "chosen", "placed"),
    [
        (episode("across", ("right_arm", 1)), 0.0, 0.0),
        (episode("across", ("left_arm_handover", 0)), 100.0, 0.0),
        # An allocation after another attempt does not count as chosen.
        (episode("across", ("right_arm", 0), ("left_arm_handover", 1)), 0.0, 0.0),
        (episode("across", ("left_arm_handover", 0), ("right_arm", 1)), 100.0, 0.0),
    ],
)
def test_trials_without_a_dip_or_transfer_are_missed(
    far: Experience, chosen: float, placed: float
) -> None:
    rows = {each.name: each.ours for each in quantities([trial(far)] * 10, 0)}
    assert [rows[name] for name in rows if "is chosen" in name] == [chosen]
    assert [rows[name] for name in rows if "comes to the reward" in name] == [placed]


def test_level_curve_is_judged_as_no_dip() -> None:
    dip, *_ = quantities([trial(HANDED, dip=False)] * 10, 0)
    assert dip.verdict is not Verdict.REPRODUCED


@pytest.mark.slow
def test_experiment_resumes_from_kept_trials(tmp_path: Path) -> None:
    pytest.importorskip("mujoco")
    settings = RunSettings(
        seed=5530000, quick=True, trials=1, folder=tmp_path, backend="mujoco", cameras="ideal"
    )
    result = hand_transfer.run(settings, "fig-7.4-7.6")
    assert len(result.charts) == 2
    assert hand_transfer.run(settings, "fig-7.4-7.6").quantities == result.quantities
