"""Episodes on a backend, as learning sees them."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from cbdsl.documents.robot import RobotDocument
from cbdsl.kinematics.kinematics import Kinematics
from cbdsl.program.transition import Transition
from cbdsl.runtime.policies.policy import Choice, Policy, WrittenPolicy
from cbdsl.training.episode_runner import BackendEpisodeRunner, moved
from tests.conftest import Checked
from tests.runtime.conftest import made_stage, on_table
from tests.runtime.synthetic import SyntheticBackend


@pytest.fixture
def backend(dexter: RobotDocument, urdf: Path) -> SyntheticBackend:
    return SyntheticBackend(dexter, urdf, lambda rng: on_table())


@pytest.fixture
def runner(
    dexter: RobotDocument, kinematics: Kinematics, backend: SyntheticBackend
) -> BackendEpisodeRunner:
    return BackendEpisodeRunner(dexter, kinematics, backend, made_stage({}))


def test_episode_reports_where_the_effector_was_rewarded(
    runner: BackendEpisodeRunner,
    backend: SyntheticBackend,
    kinematics: Kinematics,
    checked: Checked,
) -> None:
    seen: list[Transition] = []
    program = checked("searchtrack")
    found = runner.run(program, WrittenPolicy(program.policy), 4, seen.append)
    assert found.reward == 1 and found.transitions[-1].rewarding == ("track",)
    assert tuple(seen) == found.transitions
    head = backend.observe().positions[kinematics.joints.of("head")]
    assert found.rewarded["head"] == pytest.approx(tuple(head))


def test_transitions_of_a_used_program_are_not_those_of_its_user(
    runner: BackendEpisodeRunner, checked: Checked
) -> None:
    seen: list[Transition] = []
    program = checked("reachtouch")
    only_looking = WrittenPolicy({"XXX": "searchtrack"})
    found = runner.run(program, only_looking, 4, seen.append)
    assert {transition.program for transition in seen} == {"reachtouch"}
    assert found.reward == 0 and found.rewarded == {}


def test_episode_without_reward_ends_by_its_transitions(
    runner: BackendEpisodeRunner, checked: Checked
) -> None:
    class Searching(Policy):
        def choose(self, state: str, *, changed: bool, features: object = None) -> Choice:
            return Choice("search")

    program = checked("searchtrack")._replace(transitions=5)
    found = runner.run(program, Searching(), 4, lambda transition: None)
    assert len(found.transitions) == 5 and found.reward == 0


@pytest.mark.parametrize(
    ("program", "member", "effector"),
    [
        ("searchtrack", "track", "head"),
        ("tactileprobe", "touch", "right_hand"),
        ("reachtouch", "reach", "right_arm"),
    ],
)
def test_moved_returns_the_effector_of_a_controller(
    checked: Checked, kinematics: Kinematics, program: str, member: str, effector: str
) -> None:
    controller = checked(program).primitives[member].lead
    assert moved(controller) == effector
    joints = [kinematics.joints.index[name] for name in controller.joints]
    assert np.isin(joints, kinematics.joints.of(effector)).all()


@pytest.mark.slow
def test_episodes_of_a_reused_runner_equal_those_of_fresh_ones(
    dexter: RobotDocument, kinematics: Kinematics, urdf: Path, checked: Checked
) -> None:
    """State kept for the next episode, under either policy, changes nothing."""
    program = checked("searchtrack")
    written, other = WrittenPolicy(program.policy), WrittenPolicy({"**": "search"})

    def runner() -> BackendEpisodeRunner:
        backend = SyntheticBackend(dexter, urdf, lambda rng: on_table())
        return BackendEpisodeRunner(dexter, kinematics, backend, made_stage({}))

    used = runner()
    for policy, seed in ((written, 4), (written, 5), (other, 4), (written, 4)):
        found = used.run(program, policy, seed, lambda transition: None)
        assert found == runner().run(program, policy, seed, lambda transition: None)
