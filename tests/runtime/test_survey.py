"""``survey`` refuses before motion, with a reason, by sizes that the cameras measure."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from cbdsl.backends.backend import embody
from cbdsl.documents.program import ProgramDocument
from cbdsl.documents.robot import RobotDocument
from cbdsl.documents.stage import StageDocument
from cbdsl.kinematics.kinematics import Kinematics
from cbdsl.runtime.episode import Runner
from cbdsl.runtime.episode_observer import EpisodeListeners
from cbdsl.runtime.tick import Tick
from cbdsl.types.state import matches
from tests.backends.conftest import LIBRARY, stage_named
from tests.conftest import Checked


@pytest.fixture(scope="module")
def backend(dexter: RobotDocument, urdf: Path) -> Iterator[object]:
    backend = embody("kinematic", dexter, urdf)
    yield backend
    backend.close()


@pytest.fixture(scope="module")
def objects() -> StageDocument:
    return stage_named("everyday_objects")


@pytest.mark.parametrize(
    ("context", "reason"),
    [
        ("parcel", "wider than the hand"),
        ("medicine_ball", "wider than the hand"),
        ("die", "too small for the fingers"),
        ("softball", ""),
        ("matchbox", ""),
        ("cereal_box", "too heavy for the hand if it is full"),
        ("paperback", "too flat for its width"),
        ("hammer", "too long for one hand"),
        ("screwdriver", ""),
    ],
)
@pytest.mark.parametrize("seed", [61_000, 61_001])
def test_survey_of_an_object_names_the_reason_of_a_refusal_and_moves_no_arm(
    context: str, reason: str, seed: int, backend: object, objects: StageDocument,
    dexter: RobotDocument, kinematics: Kinematics, checked: Checked,
) -> None:  # fmt: skip
    runner = Runner(dexter, kinematics, checked("survey"), backend)  # type: ignore[arg-type]
    postures: list[np.ndarray] = []

    def note(tick: Tick) -> None:
        postures.append(tick.observation.positions[tick.signals.joints.of("right_arm")])

    result = runner.run(objects, seed, context, observer=EpisodeListeners(on_tick=note))
    assert result.outcome == ("failure" if reason else "success"), result.ending
    assert reason in result.ending
    assert np.ptp(postures, axis=0).max() < 0.02


@pytest.mark.parametrize(
    ("context", "seed", "reason"),
    [
        ("parcel", 90_302, ""),
        ("parcel", 90_303, "out of reach of the left hand"),
        ("paint_can", 90_301, "out of reach of both hands"),
        ("paint_can", 90_302, ""),
        ("play_ball", 90_301, "may roll away between the hands"),
        ("tray", 90_301, "too low for both hands"),
        ("cereal_box", 90_301, "no wider than one hand"),
        ("softball", 90_301, "no wider than one hand"),
    ],
)
def test_survey_for_both_accepts_large_objects_within_reach_and_moves_no_arm(
    context: str, seed: int, reason: str, backend: object, objects: StageDocument,
    dexter: RobotDocument, kinematics: Kinematics, checked: Checked,
) -> None:  # fmt: skip
    runner = Runner(dexter, kinematics, checked("survey_for_both"), backend)  # type: ignore[arg-type]
    postures: list[np.ndarray] = []

    def note(tick: Tick) -> None:
        joints = tick.signals.joints
        arms = [*joints.of("right_arm"), *joints.of("left_arm")]
        postures.append(tick.observation.positions[arms])

    result = runner.run(objects, seed, context, observer=EpisodeListeners(on_tick=note))
    assert result.outcome == ("failure" if reason else "success"), result.ending
    assert reason in result.ending
    assert np.ptp(postures, axis=0).max() < 0.02


def test_survey_with_a_larger_margin_refuses_an_object_within_the_hand(
    backend: object, objects: StageDocument, dexter: RobotDocument, kinematics: Kinematics,
    checked: Checked,
) -> None:  # fmt: skip
    """The bound comes from the hand's own opening, not from a number for the objects."""
    program = checked("survey", margin="20 cm")
    runner = Runner(dexter, kinematics, program, backend)  # type: ignore[arg-type]
    result = runner.run(objects, 61_000, "softball")
    assert result.outcome == "failure" and "wider than the hand" in result.ending


@pytest.mark.parametrize("name", LIBRARY.names(ProgramDocument))
def test_shipped_program_that_states_failures_ends_if_a_used_program_cannot_go_on(
    name: str, checked: Checked
) -> None:
    """Take the first state in which a used program is undefined; it is continued, or an end."""
    program = checked(name)
    if not program.failure:
        return
    for member in {action.name for action in program.actions if action.program is not None}:
        state = "".join("-" if each == member else "X" for each in program.members)
        handled = (*program.policy, *program.success, *program.failure)
        assert any(matches(pattern, state) for pattern in handled), state


@pytest.mark.parametrize(("name", "state"), [("survey", "X-"), ("take_with_both", "-X")])
def test_search_for_an_object_that_is_not_there_ends_in_a_failure_with_its_reason(
    name: str, state: str, backend: object, dexter: RobotDocument, kinematics: Kinematics,
    checked: Checked,
) -> None:  # fmt: skip
    program = checked(name, feature="hue_3")
    (search,) = (action for action in program.actions if action.name == "searchtrack")
    assert search.program is not None
    # The search gives up after the transitions of a shorter attempt.
    short = search.program._replace(transitions=4)
    actions = tuple(
        action._replace(program=short) if action is search else action for action in program.actions
    )
    runner = Runner(dexter, kinematics, program._replace(actions=actions), backend)  # type: ignore[arg-type]
    result = runner.run(stage_named("table_right"), 1)
    assert result.outcome == "failure" and result.predicates[-1].startswith(state)
    assert result.ending.endswith("no object of this colour is in sight.")
