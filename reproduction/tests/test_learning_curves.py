"""Settling of learning curves."""

from __future__ import annotations

import numpy as np
import pytest
from drawn_experience import experience

from cbdsl_reproduction.chapter_4.learning_curves import per_transition, settled_at


@pytest.mark.parametrize("jump", [5, 12, 25])
def test_curve_with_a_step_settles_at_the_step(jump: int) -> None:
    curve = np.where(np.arange(50) < jump, 0.1, 0.5)
    rewards = np.tile(curve, (8, 1)) + np.random.default_rng(0).normal(0, 0.001, (8, 50))
    assert abs(settled_at(rewards) - jump) <= 1


def test_level_curve_settles_at_the_first_episode() -> None:
    assert settled_at(np.full((4, 50), 0.3)) == 1


def test_reward_is_shared_among_transitions() -> None:
    steps = [("XX", "a", "X0"), ("X0", "a", "X1")]
    assert per_transition(experience(*steps, reward=1)) == 0.5
    assert per_transition(experience(*steps)) == 0
