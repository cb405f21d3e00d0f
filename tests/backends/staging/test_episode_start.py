"""An episode begins in a context that is drawn or named, and in the posture that it says."""

from __future__ import annotations

import numpy as np
import pytest

from cbdsl.backends.backend import BackendError
from cbdsl.backends.staging.episode_start import choose_context, starting_posture
from cbdsl.documents.context import Context
from cbdsl.documents.robot import RobotDocument
from cbdsl.documents.stage import StageDocument
from cbdsl.robot.joints import Joints
from tests.backends.conftest import Simulated, made_stage


def test_contexts_are_drawn_by_their_shares() -> None:
    stage = StageDocument.model_validate(
        {**made_stage({}).model_dump(), "contexts": {"often": {"share": 3}, "seldom": {"share": 1}}}
    )
    rng = np.random.default_rng(0)
    drawn = [choose_context(stage, None, rng) for _ in range(400)]
    assert 265 <= drawn.count("often") <= 335


def test_joints_start_in_their_postures_or_where_the_context_says(
    simulated: Simulated, dexter: RobotDocument
) -> None:
    simulated.reset(made_stage({"joints": {"pan": [0.2, 0.3]}}), None, np.random.default_rng(0))
    start = simulated.truth.read()[0]
    joints = Joints(dexter)
    assert 0.2 <= start[joints.index["pan"]] <= 0.3
    for name, effector in dexter.effectors.items():
        assert effector.start is not None
        for joint, angle in zip(effector.joints, effector.postures[effector.start], strict=True):
            if joint != "pan":
                assert start[joints.index[joint]] == pytest.approx(angle), name


def test_stage_joints_leave_the_start_of_other_joints(dexter: RobotDocument) -> None:
    joints, rng = Joints(dexter), np.random.default_rng(0)
    head = dexter.effectors["head"].model_copy(update={"start": None})
    robot = dexter.model_copy(update={"effectors": {**dexter.effectors, "head": head}})
    elsewhere = np.full(len(joints), 0.25)
    start = starting_posture(Context(), robot, joints, elsewhere, rng)
    assert (start[joints.of("head")] == 0.25).all()
    assert (elsewhere == 0.25).all()


def test_unknown_names_are_reported_with_the_known_ones(simulated: Simulated) -> None:
    rng = np.random.default_rng(0)
    with pytest.raises(BackendError, match=r"'nowhere'.*only"):
        simulated.reset(made_stage({}), "nowhere", rng)
    with pytest.raises(BackendError, match="no actuated joint 'elbow'"):
        simulated.reset(made_stage({"joints": {"elbow": 0}}), None, rng)
