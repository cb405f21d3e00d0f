"""``pick_and_place`` and ``deliver`` with physics: on the pad, never placed in the air."""

from __future__ import annotations

import math
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from cbdsl.backends.backend import embody
from cbdsl.documents.robot import RobotDocument
from cbdsl.kinematics.kinematics import Kinematics
from cbdsl.program.transition import Transition
from cbdsl.runtime.episode import Runner
from cbdsl.runtime.episode_observer import EpisodeListeners
from cbdsl.runtime.policies.policy import Choice, Policy
from cbdsl.runtime.tick import Tick
from tests.backends.conftest import stage_named
from tests.conftest import Checked

pytestmark = pytest.mark.slow
pytest.importorskip("mujoco")


@pytest.fixture(scope="module")
def backend(dexter: RobotDocument, urdf: Path) -> Iterator[object]:
    backend = embody("mujoco", dexter, urdf, cameras="ideal")
    yield backend
    backend.close()


@pytest.mark.parametrize("thing", ["ball", "cube", "cylinder", "box"])
def test_thing_is_lifted_carried_and_placed(
    thing: str, backend: object, dexter: RobotDocument, kinematics: Kinematics, checked: Checked
) -> None:
    truth = backend.truth  # type: ignore[attr-defined]
    heights: list[float] = []
    borne: list[frozenset[str]] = []

    def note(tick: Tick) -> None:
        heights.append(float(truth.pose(thing).position[2]))

    def hear(transition: Transition) -> None:
        if transition.depth == 0 and transition.next_state == "1XXXXX":  # pick_and_place is over
            borne.append(truth.neighbours(thing))

    runner = Runner(dexter, kinematics, checked("deliver"), backend)  # type: ignore[arg-type]
    observer = EpisodeListeners(hear, note)
    result = runner.run(stage_named("things_and_a_pad"), 83_003, thing, observer)
    assert result.outcome == "success"
    assert len(borne) == 1 and "pad" in borne[0]
    assert max(heights) > heights[0] + 0.05
    place, pad = truth.pose(thing).position, truth.pose("pad").position
    assert math.dist(place[:2], pad[:2]) < 0.02
    assert truth.neighbours(thing) and not truth.touched(thing)
    assert np.linalg.norm(truth.velocity(thing)) < 0.01


def test_transport_and_place_are_undefined_for_an_empty_hand(
    backend: object, dexter: RobotDocument, kinematics: Kinematics, checked: Checked
) -> None:
    """Leave both undefined unless an object is held, regardless of the images."""
    program = checked("pick_and_place")
    runner = Runner(dexter, kinematics, program, backend)  # type: ignore[arg-type]
    states: set[str] = set()

    class Both(Policy):
        """A policy that never grasps."""

        def choose(self, state: str, *, changed: bool, features: object = None) -> Choice:
            states.add(state)
            return Choice("transport ◁ place" if changed else None)

    runner._policy = Both()
    result = runner.run(stage_named("things_and_a_pad"), 83_004, "ball")
    assert states == {"XXX", "X--"} and not result.rewarded


def test_carried_object_avoids_a_seen_obstacle(
    backend: object, dexter: RobotDocument, kinematics: Kinematics, checked: Checked
) -> None:
    """Higher above the column than where that is no obstacle, and on the pad either way."""
    truth = backend.truth  # type: ignore[attr-defined]
    highest = {}
    for obstacle in ("blue", "yellow"):
        heights: list[float] = []

        def note(tick: Tick, heights: list[float] = heights) -> None:
            heights.append(float(truth.pose("ball").position[2]))

        program = checked("deliver", obstacle=obstacle)
        runner = Runner(dexter, kinematics, program, backend)  # type: ignore[arg-type]
        # Without knowledge of the column, the ball is lost with four of the seeds 1 to 6.
        result = runner.run(
            stage_named("column_before_pad"), 3, observer=EpisodeListeners(on_tick=note)
        )
        assert result.outcome == "success", result.ending
        assert "pad" in truth.neighbours("ball")
        highest[obstacle] = max(heights)
    assert highest["blue"] > highest["yellow"] + 0.05
