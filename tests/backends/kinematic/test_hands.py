"""Frames that move with the hands that hold an object."""

from __future__ import annotations

from itertools import pairwise
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from cbdsl.backends.kinematic.hands import Hands
from cbdsl.kinematics.pose import Pose

BOTH = ("one", "other")


def hands_at(turn: float) -> Any:
    """Return two hands 30 cm apart, the first turned about the vertical by ``turn``, rad."""
    poses = {
        "one": Pose(np.zeros(3), Rotation.from_euler("z", turn).as_matrix()),
        "other": Pose(np.array([0.3, 0.0, 0.0]), np.eye(3)),
    }
    # Upright, the first hand's third axis is orthogonal to the line between the hands.
    poses["one"] = Pose(
        np.zeros(3), poses["one"].rotation @ Rotation.from_euler("x", 0.4).as_matrix()
    )
    return SimpleNamespace(
        _tree=SimpleNamespace(pose=poses.get),
        hands={name: SimpleNamespace(carrier=name) for name in BOTH},
    )


@pytest.mark.parametrize("axis", [1, 2])
def test_carrier_pose_of_two_hands_follows_a_turn_of_one_without_jumps(axis: int) -> None:
    frames = [Hands.carrier_pose(hands_at(turn), BOTH, axis) for turn in np.arange(-1.0, 1.0, 0.01)]
    steps = [
        Rotation.from_matrix(before.rotation.T @ after.rotation).magnitude()
        for before, after in pairwise(frames)
    ]
    assert max(steps) < 0.05


def test_cross_axis_changes_as_a_hand_turns() -> None:
    axes = {Hands.cross_axis(hands_at(turn), BOTH) for turn in np.arange(-1.5, 1.5, 0.01)}
    assert len(axes) > 1
    assert Hands.cross_axis(hands_at(0.0), ("one",)) == 0
