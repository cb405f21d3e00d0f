"""Learned policies end where their tables go in circles."""

from __future__ import annotations

from pathlib import Path

import pytest

from cbdsl.backends.kinematic.backend import KinematicBackend
from cbdsl.documents.robot import RobotDocument
from cbdsl.kinematics.kinematics import Kinematics
from cbdsl.program.checked import CheckedProgram
from cbdsl.program.condition import ProgramCondition
from cbdsl.runtime.episode import Runner
from cbdsl.runtime.episode_result import EpisodeResult
from cbdsl.runtime.policies.learned_policy import LearnedPolicy, own_policy
from cbdsl.runtime.policies.policy import Choice, WrittenPolicy
from tests.backends.conftest import stage_named
from tests.conftest import Checked

TABLE = {
    "X0-": "reach ◁ touch",
    "X1-": "searchtrack",
    "0XX": "searchtrack",
    "1XX": "touch ◁ reach",
    "***": "searchtrack",
}
ROUND = ("X0-", "X1-", "0XX", "1XX")


@pytest.fixture
def learned(checked: Checked) -> CheckedProgram:
    """Return REACHTOUCH under a table that always tries again."""
    return checked("reachtouch")._replace(policy=TABLE, is_learned=True)


def choices(policy: LearnedPolicy, *states: str) -> list[str | None]:
    return [policy.choose(state, changed=True).action for state in states]


def test_learned_policy_chooses_by_its_table(learned: CheckedProgram) -> None:
    policy, table = LearnedPolicy(learned), WrittenPolicy(TABLE)
    states = ("XXX", *ROUND * 5)
    assert choices(policy, *states) == [
        table.choose(state, changed=True).action for state in states
    ]
    assert policy.choose("X0-", changed=False) == Choice(None), "as any table that changed nothing"


def test_learned_policy_ends_a_repeated_circle_of_states(learned: CheckedProgram) -> None:
    policy = LearnedPolicy(learned)
    *before, last = (policy.choose(s, changed=True) for s in ("XXX", *(ROUND * 8)[:-2]))
    assert None not in [each.action for each in before]
    assert last == Choice(None, "", "it goes in circles: X0- -> X1- 8 times without a reward")


def test_alternating_contact_is_no_circle(learned: CheckedProgram) -> None:
    """Only rest takes its time; letters of a touch may flicker."""
    policy = LearnedPolicy(learned)
    assert None not in choices(policy, "XXX", *("X0-", "X00") * 50)


def test_condition_that_alternates_is_no_circle(checked: Checked, learned: CheckedProgram) -> None:
    """A true condition has the letter of rest, but its signal may flicker."""
    condition = ProgramCondition("near", "", (), 0.0)
    program = learned._replace(
        members=(*learned.members, "near"), conditions={"near": condition}, policy={"****": "touch"}
    )
    policy = LearnedPolicy(program)
    assert None not in choices(policy, "XXXX", *("X0-0", "X0-1") * 50)
    assert choices(policy, *("X0-0", "X1-0") * 50)[-1] is None, "rest beside a condition counts"


def test_failed_program_is_not_restarted_immediately(learned: CheckedProgram) -> None:
    policy = LearnedPolicy(learned)
    assert choices(policy, "XXX", "0XX") == ["searchtrack"] * 2
    choice = policy.choose("-XX", changed=True)
    assert choice.action is None and choice.reason.startswith("searchtrack has failed")


def test_count_of_circles_restarts_in_an_idle_state(learned: CheckedProgram) -> None:
    policy = LearnedPolicy(learned)
    choices(policy, "XXX", *ROUND * 7)
    assert None not in choices(policy, "XXX", *ROUND * 7)


def test_circle_with_drawn_references_does_not_end(checked: Checked) -> None:
    program = checked("searchtrack")._replace(is_learned=True, policy={"**": "track ◁ search"})
    assert None not in choices(LearnedPolicy(program), "XX", *("0-", "1-") * 40)


def test_written_policy_never_ends_a_circle(learned: CheckedProgram) -> None:
    written = own_policy(learned._replace(is_learned=False))
    assert isinstance(written, WrittenPolicy)
    assert isinstance(own_policy(learned), LearnedPolicy)


@pytest.mark.parametrize(
    ("stage", "clause"), [("out_of_reach", "circles"), ("absent", "searchtrack has failed")]
)
def test_circle_without_reward_ends_the_episode_with_a_reason(
    learned: CheckedProgram,
    dexter: RobotDocument,
    urdf: Path,
    kinematics: Kinematics,
    stage: str,
    clause: str,
) -> None:
    def play(program: CheckedProgram) -> EpisodeResult:
        body = KinematicBackend(dexter, urdf)
        return Runner(dexter, kinematics, program, body).run(stage_named(stage), 5600100)

    result = play(learned)
    assert not result.rewarded and clause in result.ending
    assert result.sim_seconds < 0.6 * play(learned._replace(is_learned=False)).sim_seconds
