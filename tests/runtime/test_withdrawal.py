"""After an attempt that failed, arms and hands go back before a schema tries another."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from cbdsl.backends.kinematic.backend import KinematicBackend
from cbdsl.checking.assimilation import program_to_assimilate
from cbdsl.checking.session import Session
from cbdsl.documents.policy import PolicyDocument
from cbdsl.documents.program import ProgramDocument
from cbdsl.documents.robot import RobotDocument
from cbdsl.documents.stage import StageDocument
from cbdsl.kinematics.kinematics import Kinematics
from cbdsl.program.checked import CheckedProgram
from cbdsl.program.schema import Features, Ranking
from cbdsl.runtime.episode import Runner
from cbdsl.runtime.episode_observer import EpisodeListeners
from cbdsl.runtime.policies.policy import Choice, Policy
from cbdsl.runtime.policies.schema_policy import SchemaPolicy
from cbdsl.runtime.tick import Tick
from cbdsl.yaml_text.library import Library
from tests.conftest import ROOT


@pytest.fixture(scope="module")
def schema() -> CheckedProgram:
    library = Library(ROOT)
    policy = library.read(library.locate(PolicyDocument, "reachtouch"), PolicyDocument)
    path = library.locate(ProgramDocument, "reachtouch")
    program = program_to_assimilate(path, policy, Session(library), {})
    return program._replace(transition_time=8.0, idle_time=1.0)


def bimanual_first(features: Features) -> Ranking:
    return ("reachtouch_bimanual", "right_arm")


@pytest.mark.parametrize("seed", range(8410000, 8410003))
def test_both_arms_withdraw_before_the_next_allocation(
    dexter: RobotDocument,
    urdf: Path,
    kinematics: Kinematics,
    stage: Callable[[str], StageDocument],
    schema: CheckedProgram,
    seed: int,
) -> None:
    """Withdraw both hands: they cannot press on a small object on the right, and would hide it."""
    backend = KinematicBackend(dexter, urdf)
    policy = SchemaPolicy(schema, bimanual_first, gives_up=False)
    runner = Runner(dexter, kinematics, schema, backend, policy)
    begun: list[np.ndarray] = []
    withdrawn = 0

    def note(tick: Tick) -> None:
        nonlocal withdrawn
        action = tick.run.action
        withdrawn += action is None and tick.run.predicate == "0"
        if withdrawn and action is not None and not begun and action.allocation:
            columns = tick.signals.joints.of("left_arm")
            begun.append(tick.observation.positions[columns])

    result = runner.run(
        stage("near_and_far_training"), seed, "right", observer=EpisodeListeners(on_tick=note)
    )
    backend.close()
    assert withdrawn > 20 and result.actions[-1].endswith("with right_arm")
    assert result.rewarded, result.ending
    home = np.array(dexter.effectors["left_arm"].postures["home"])
    assert np.abs(begun[0] - home).max() < 0.1


class GivesWay(Policy):
    """Looks for the thing, then withdraws from the middle of it, and does nothing more."""

    allocates = True

    def __init__(self) -> None:
        self._choices = iter(("searchtrack", "withdraw"))

    def choose(self, state: str, *, changed: bool, features: object = None) -> Choice:
        name = next(self._choices, None)
        return Choice(None, withdraws=True) if name == "withdraw" else Choice(name)


def test_program_that_is_withdrawn_from_is_left(
    dexter: RobotDocument,
    urdf: Path,
    kinematics: Kinematics,
    stage: Callable[[str], StageDocument],
    schema: CheckedProgram,
) -> None:
    backend = KinematicBackend(dexter, urdf)
    runner = Runner(dexter, kinematics, schema, backend, GivesWay())
    left: set[str] = set()

    def note(tick: Tick) -> None:
        if tick.run.action is None:
            left.add(tick.run.children["searchtrack"].predicate)

    result = runner.run(
        stage("near_and_far_training"), 8_410_010, "right", observer=EpisodeListeners(on_tick=note)
    )
    backend.close()
    assert result.actions[0] == "searchtrack" and left == {"X"}
