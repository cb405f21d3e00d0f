"""Judge of served robots, which compares a robot behind ROS 2 with one in process."""

from __future__ import annotations

import pytest

from cbdsl.backends.backend import BackendError
from cbdsl_reproduction.judges import served
from cbdsl_reproduction.judges.judge import BodyChoice, EpisodeVerdict


def verdict(name: str, body: BodyChoice) -> EpisodeVerdict:
    (condition,) = (each for each in served.JUDGE.conditions if each.name == name)
    (only,) = served.JUDGE.measure(condition, body, [500])
    return only


def test_served_judge_counts_an_episode_in_process() -> None:
    outcome = verdict("reachtouch, in process", BodyChoice("kinematic", "ideal"))
    assert outcome.outcomes == {"rewarded": True} and outcome.measures["load_percent"] > 0


def test_served_judge_counts_a_held_robot_as_unrewarded(monkeypatch: pytest.MonkeyPatch) -> None:
    def hold(*_: object, **__: object) -> None:
        raise BackendError("the robot holds")

    monkeypatch.setattr(served.Runner, "run", hold)
    outcome = verdict("reachtouch, in process", BodyChoice("kinematic", "ideal"))
    assert outcome.outcomes == {"rewarded": False} and outcome.ending == "the robot holds"


@pytest.mark.slow
def test_served_judge_counts_an_episode_of_a_served_robot() -> None:
    pytest.importorskip("cyclonedds")
    outcome = verdict("reachtouch, served", BodyChoice("mujoco", "ideal"))
    assert outcome.outcomes == {"rewarded": True}, outcome.ending
