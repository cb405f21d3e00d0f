"""Backends with an engine: their chance, cameras and stages, and the models that they refuse."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from cbdsl.backends.backend import BackendError
from cbdsl.backends.staging.world_state import GroundTruthProvider
from cbdsl.documents.robot import RobotDocument
from cbdsl.documents.stage import StageDocument
from cbdsl.extend.contract.test_backend import episode
from tests.backends.conftest import (
    LIBRARY,
    URDF,
    Simulated,
    robot_named,
    stage_named,
    with_vision,
)
from tests.conftest import ROOT

STAGES = LIBRARY.names(StageDocument)


def test_another_seed_is_another_episode(simulated: Simulated) -> None:
    stage = stage_named("noisy_right")
    assert episode(simulated, stage, 4) != episode(simulated, stage, 3)


def test_sensor_noise_does_not_depend_on_other_draws(simulated: Simulated) -> None:
    rng = np.random.default_rng(0)
    simulated.reset(stage_named("absent"), None, rng)
    state = rng.bit_generator.state
    simulated.step()
    assert rng.bit_generator.state == state


def test_stage_is_set_up_around_a_robot_that_stays(unseeing: Simulated) -> None:
    stage = stage_named("things_and_a_pad")
    unseeing.reset(stage, None, np.random.default_rng(1))
    away = unseeing.observe().positions.copy()
    away[0] += 0.3
    for _ in range(60):
        unseeing.apply(away)
        unseeing.step()
    before = unseeing.truth.read()[0].copy()
    context = unseeing.set_up_around(stage, None, np.random.default_rng(2))
    assert unseeing.truth.read()[0].tobytes() == before.tobytes()
    assert unseeing.observe().time == 0.0
    placed = {name: unseeing.truth.pose(name).position.copy() for name in unseeing.truth.names()}
    unseeing.apply(away)
    unseeing.step()
    assert unseeing.truth.read()[0] == pytest.approx(before, abs=1e-3)
    assert unseeing.reset(stage, None, np.random.default_rng(2)) == context
    assert placed.keys() == set(unseeing.truth.names())
    for name, position in placed.items():
        assert unseeing.truth.pose(name).position == pytest.approx(position, abs=1e-9), name


@pytest.mark.parametrize("rate", [30.0, 25.0, 15.0, 7.0])
def test_cameras_look_at_their_rate(
    make: type[Simulated], dexter: RobotDocument, rate: float
) -> None:
    backend = make(with_vision(dexter, rate=rate, latency=0.0), URDF)
    backend.reset(stage_named("absent"), None, np.random.default_rng(0))
    times = []
    for _ in range(round(1.0 / backend.control_period)):
        observation = backend.observe()
        assert not (observation.images and observation.regions)
        if seen := observation.images or observation.regions:
            assert set(seen) == set(dexter.cameras)
            times.append(observation.time)
        backend.step()
    backend.close()
    assert times[0] == 0
    assert len(times) == rate
    assert np.diff(times) == pytest.approx(1 / rate, abs=backend.control_period + 1e-9)


@pytest.mark.parametrize("latency", [0.0, 0.1, 0.3])
def test_images_come_as_late_as_the_robot_says(
    make: type[Simulated], dexter: RobotDocument, latency: float
) -> None:
    """Take the first image before any motion; later ones arrive one after the other."""
    backend = make(with_vision(dexter, latency=latency), URDF, cameras="ideal")
    backend.reset(stage_named("table_right"), "in_view", np.random.default_rng(0))
    late = []
    for _ in range(round(1.0 / backend.control_period)):
        observation = backend.observe()
        if observation.regions:
            assert observation.exposed is not None
            late.append(observation.time - observation.exposed)
        else:
            assert observation.exposed is None
        backend.step()
    backend.close()
    assert late[0] == 0
    assert len(late) >= 10
    assert late[1:] == pytest.approx([latency] * (len(late) - 1))


@pytest.mark.parametrize("name", STAGES)
def test_every_context_of_every_shipped_stage_can_begin(make: type[Simulated], name: str) -> None:
    stage = stage_named(name)
    robot = robot_named(stage.robot)
    backend = make(robot, ROOT / "robots" / robot.model)
    for context, content in stage.contexts.items():
        assert backend.reset(stage, context, np.random.default_rng(1)) == context
        assert isinstance(backend, GroundTruthProvider)
        shown = set(backend.truth.names()) - set(stage.fixtures)
        first = [each for each in content.placed.values() if each.from_turn == 0]
        assert len(shown) == (len(first) or bool(content.things))
        assert shown <= {*content.things, *content.placed}
        assert all(backend.truth.parts(thing) for thing in backend.truth.names())
        backend.step()
        # Objects that are held out to a hand may touch it.
        if content.place is None or content.place.hand is None:
            assert not any(backend.truth.touched(thing) for thing in shown)
    backend.close()


@pytest.mark.parametrize(
    ("written", "instead", "complaint"),
    [
        ('name="pan"', 'name="neck"', "no movable joint 'pan'"),
        ('name="right_finger_2_distal" type', 'name="x" type', "'right_finger_2_distal'"),
        ('"left_camera"', '"x"', "no link 'left_camera'"),
        ('"torso"', '"trunk"', "base 'torso'.*'trunk'"),
        ("</robot>", "", "cannot (be )?read"),
    ],
)
def test_model_that_does_not_fit_is_refused(
    make: type[Simulated],
    dexter: RobotDocument,
    tmp_path: Path,
    written: str,
    instead: str,
    complaint: str,
) -> None:
    text = URDF.read_text()
    assert written in text
    urdf = tmp_path / "broken.urdf"
    urdf.write_text(text.replace(written, instead))
    with pytest.raises(BackendError, match=complaint):
        make(dexter, urdf)


def test_model_that_is_not_there_is_refused(
    make: type[Simulated], dexter: RobotDocument, tmp_path: Path
) -> None:
    with pytest.raises(BackendError, match=r"none\.urdf"):
        make(dexter, tmp_path / "none.urdf")
