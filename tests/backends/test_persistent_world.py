"""Worlds that go on from one episode to the next."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest

from cbdsl.backends.backend import BackendError, ResumableBackend
from cbdsl.documents.robot import RobotDocument
from cbdsl.documents.stage import StageDocument
from cbdsl.kinematics.kinematics import Kinematics
from cbdsl.kinematics.pose import Pose
from cbdsl.runtime.episode import Runner
from cbdsl.runtime.episode_observer import EpisodeListeners
from tests.backends.conftest import (
    BACKENDS,
    URDF,
    Simulated,
    made_stage,
    run,
    sightless,
    stage_named,
)
from tests.conftest import Checked

TABLE = {"form": {"shape": "box", "size": [2, 2, 0.1]}, "position": [1.5, 0, -0.45]}
BOX = {"form": {"shape": "box", "size": [0.1, 0.1, 0.1]}, "mass": 0.3}
AWAY = {"speed": 2.0, "direction": 0.0, "thrown": True}


def going_on(put_back: str, **moving: Any) -> StageDocument:
    """Return a stage with one box that stays on its table, and one that does not."""
    placed = {
        "still": {"things": ["box"], "place": {"on": "table", "x": 1.2, "y": 0.5}},
        "moving": {"things": ["box"], **moving},
    }
    world = {"persistent": True, "put_back": put_back}
    parts = {"fixtures": {"table": TABLE}, "things": {"box": BOX}, "world": world}
    return made_stage({"placed": placed}, **parts)


def began(backend: Simulated, stage: StageDocument) -> None:
    backend.reset(stage, None, np.random.default_rng(0))


def test_persistent_world_keeps_the_poses_of_objects(simulated: Simulated) -> None:
    stage = going_on("nothing", place={"on": "table", "x": 1.2}, motion={**AWAY, "speed": 0.5})
    began(simulated, stage)
    simulated.apply(simulated.observe().positions + 0.1)
    run(simulated, 0.5)
    assert isinstance(simulated, ResumableBackend)
    before = simulated.observe()
    moved = simulated.truth.pose("moving").position
    assert simulated.resume(stage, None) == "only"
    after = simulated.observe()
    assert after.time == 0.0
    assert after.positions.tobytes() == before.positions.tobytes()
    assert after.images or after.regions, "every episode begins with an image"
    assert simulated.truth.pose("moving").position == pytest.approx(moved)
    simulated.step()
    assert simulated.observe().time == pytest.approx(simulated.control_period)


def test_another_stage_resets_the_world(simulated: Simulated) -> None:
    began(simulated, stage_named("table_right"))
    assert simulated.resume(going_on("nothing", place={"z": 0}), None) is None
    assert simulated.resume(stage_named("table_right"), "out_of_view") in (None, "out_of_view")


@pytest.mark.parametrize(
    ("put_back", "direction", "returns"),
    [("nothing", 0.0, False), ("fallen", 0.0, True), ("moved", 0.0, True)],
)
def test_fallen_object_is_put_back(
    unseeing: Simulated, put_back: str, direction: float, returns: bool
) -> None:
    stage = going_on(put_back, place={"x": 0.9, "y": 1.5, "z": 0.3})
    began(unseeing, stage)
    start = {name: unseeing.truth.pose(name).position for name in unseeing.truth.names()}
    run(unseeing, 0.5)
    fallen = unseeing.truth.pose("moving").position
    assert fallen[2] < start["moving"][2] - 0.5
    unseeing.resume(stage, None)
    wanted = start["moving"] if returns else fallen
    assert unseeing.truth.pose("moving").position == pytest.approx(wanted)
    assert unseeing.truth.pose("still").position == pytest.approx(start["still"], abs=1e-3)


@pytest.mark.parametrize(("put_back", "returns"), [("fallen", False), ("moved", True)])
def test_moved_object_is_put_back_on_request(
    unseeing: Simulated, put_back: str, returns: bool
) -> None:
    motion = {"speed": 0.2, "direction": 0.0}
    stage = going_on(put_back, place={"on": "table", "x": 1.2}, motion=motion)
    began(unseeing, stage)
    start = unseeing.truth.pose("moving").position
    run(unseeing, 0.5)
    moved = unseeing.truth.pose("moving").position
    assert np.linalg.norm(moved - start) > 0.08
    unseeing.resume(stage, None)
    wanted = start if returns else moved
    assert unseeing.truth.pose("moving").position == pytest.approx(wanted, abs=1e-6)


@pytest.mark.parametrize("gap", [0.0, 0.02, 0.2])
def test_put_back_near_a_fingertip_leaves_the_object(
    gap: float, unseeing: Simulated, dexter: RobotDocument
) -> None:
    stage = going_on("nothing", place={"on": "table", "x": 1.2})
    began(unseeing, stage)
    run(unseeing, 0.2)
    before = unseeing.truth.pose("moving")
    (cell, *_) = dexter.load_cells["right_hand"].values()
    # The fingertip is within 2 cm of its link's origin, and half an edge of the box is 5 cm.
    above = np.array([0.0, 0.0, 0.05 + gap])
    place = Pose(unseeing.truth.link_pose(cell.link).position + above, np.eye(3))
    unseeing.truth.put_back("moving", place)
    expected = place if gap > 0.1 else before
    assert unseeing.truth.pose("moving").position == pytest.approx(expected.position, abs=1e-9)
    run(unseeing, 0.2)
    if gap < 0.1:
        assert unseeing.truth.pose("moving").position == pytest.approx(before.position, abs=1e-3)


@pytest.fixture(scope="module", params=list(BACKENDS))
def holding(request: pytest.FixtureRequest, dexter: RobotDocument) -> Iterator[Simulated]:
    backend = BACKENDS[request.param](sightless(dexter), URDF)
    yield backend
    backend.close()


def test_held_object_is_measured_in_the_next_episode(
    holding: Simulated, dexter: RobotDocument, kinematics: Kinematics, checked: Checked
) -> None:
    """Close the fingers on a ball; they still press on it after the tare in the next episode."""
    palm = {"hand": "right_arm", "gap": 0.02, "held": True}
    stage = made_stage(
        {"things": ["ball"], "place": palm},
        things={"ball": {"form": {"shape": "ball", "radius": 0.09}, "mass": 0.25}},
        world={"persistent": True},
    )
    program = checked("tactileprobe")
    sightless_dexter = sightless(dexter)
    runner = Runner(sightless_dexter, kinematics, program, holding)
    first = runner.run(stage, 0)
    assert first.rewarded
    forces = np.linalg.norm(runner.signals.touch.loads[:, :3], axis=1)
    assert forces.max() > 0.15

    felt: list[np.ndarray] = []
    other = Runner(sightless_dexter, kinematics, program, holding)
    other.take_over(runner)
    other.run(
        stage,
        1,
        observer=EpisodeListeners(
            on_tick=lambda tick: felt.append(
                np.linalg.norm(tick.signals.touch.loads[:, :3], axis=1)
            )
        ),
    )
    assert felt[0] == pytest.approx(forces, abs=0.1), "the bias is kept, and the grip too"


def test_backend_without_persistent_worlds_is_refused(
    unseeing: Simulated, dexter: RobotDocument, kinematics: Kinematics, checked: Checked
) -> None:
    class Forgetful:
        """A backend without ``resume``."""

        def __getattr__(self, name: str) -> Any:
            if name == "resume":
                raise AttributeError(name)
            return getattr(unseeing, name)

    stage = made_stage({}, world={"persistent": True})
    runner = Runner(sightless(dexter), kinematics, checked("posture"), Forgetful())  # type: ignore[arg-type]
    runner.run(stage, 0)
    with pytest.raises(BackendError, match="this backend offers none"):
        runner.run(stage, 1)
