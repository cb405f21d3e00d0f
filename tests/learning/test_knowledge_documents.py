"""Knowledge of a trial: a policy, models named after it, and one entry of the curve an episode."""

from __future__ import annotations

import pytest

from cbdsl.checking.program import check_program
from cbdsl.documents.model import Gaussian
from cbdsl.documents.policy import Provenance
from cbdsl.learning.experience import Experience
from cbdsl.learning.knowledge_documents import curve_of, model_documents, policy_document
from cbdsl.learning.learner import TrialSummary
from cbdsl.program.transition import Transition
from cbdsl.yaml_text.library import Library
from tests.conftest import ROOT


def episode(context: str, rewards: tuple[int, ...], ticks: int) -> Experience:
    steps = tuple(Transition("p", 0, 0.0, "0X", "track", "1X", 3, each) for each in rewards)
    return Experience(context, 1, steps, {}, ticks, 0.1)


EPISODES = (episode("left", (0, 1), 7), episode("right", (0, 0, 0), 11), episode("left", (1,), 4))


@pytest.fixture
def summary() -> TrialSummary:
    digest = "0" * 64
    same = {"name": "searchtrack", "sha256": digest}
    provenance = Provenance.model_validate(
        {
            "command": "cb learn searchtrack", "program": same, "actions": ("search", "track"),
            "robot": same, "stage": same, "algorithm": "accommodate", "constants": {}, "seed": 1,
            "episodes": 3, "backend": "kinematic", "renderer": "none", "versions": {},
        }
    )  # fmt: skip
    program = check_program("searchtrack", {}, Library(ROOT))
    return TrialSummary("mine", program, {"seen_from": "head"}, EPISODES, provenance)


def test_curve_has_an_entry_for_each_episode() -> None:
    curve = curve_of(EPISODES)
    assert curve.context == ("left", "right", "left")
    assert curve.reward == (1, 0, 1)
    assert curve.transitions == (2, 3, 1)
    assert curve.ticks == (7, 11, 4)


def test_models_are_named_after_their_policy(summary: TrialSummary) -> None:
    density = Gaussian(form="gaussian", mean=(0.1,), deviation=(0.2,), uniform=0.5)
    (model,) = model_documents(summary, {"head": density})
    policy = policy_document(summary, {"**": "track"}, values={"XX": {"track": 0.5}})
    assert policy.models == {"seen_from": model.name}
    assert (model.effector, model.robot, model.density) == ("head", "dexter", density)
    assert "searchtrack" in model.description
    assert (policy.name, policy.program) == ("mine", "searchtrack")
    assert policy.policy == {"**": "track"} and policy.values == {"XX": {"track": 0.5}}
    assert policy.predicates == summary.program.members
    assert policy.provenance == summary.provenance and policy.curve == curve_of(EPISODES)
    assert "ACCOMMODATE" in policy.description
