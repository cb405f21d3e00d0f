"""The backends' contract: the same seed gives the same episode, and only sensors are seen."""

from __future__ import annotations

import dataclasses
from pathlib import Path

import numpy as np
import pytest

from cbdsl.backends.backend import BackendError
from cbdsl.backends.staging.world_state import GroundTruthProvider
from cbdsl.documents.robot import RobotDocument
from cbdsl.documents.stage import StageDocument
from cbdsl.sensing.observation import Observation
from tests.backends.conftest import (
    LIBRARY,
    URDF,
    Either,
    robot_named,
    stage_named,
    with_vision,
)
from tests.conftest import ROOT

STAGES = LIBRARY.names(StageDocument)


def _episode(backend: Either, seed: int, steps: int = 24) -> list[bytes]:
    """All that is observed of an episode in which the arms move towards the table."""
    backend.reset(stage_named("noisy_right"), None, np.random.default_rng(seed))
    seen = []
    reference = backend.observe().positions
    for _ in range(steps):
        seen.append(_bytes(backend.observe()))
        reference = reference + 0.01
        backend.apply(reference)
        backend.step()
    return seen


def _bytes(observation: Observation) -> bytes:
    arrays = [observation.positions, observation.velocities]
    arrays += [*observation.loads.values(), *observation.images.values()]
    regions = repr({camera: dict(found) for camera, found in observation.regions.items()})
    return b"".join(np.ascontiguousarray(array).tobytes() for array in arrays) + regions.encode()


def test_same_seed_same_bytes_whatever_ran_before(
    either: Either, make: type[Either], dexter: RobotDocument
) -> None:
    first = _episode(either, 3)
    assert _episode(either, 4) != first
    assert _episode(either, 3) == first
    other = make(dexter, URDF)
    assert _episode(other, 3) == first
    other.close()


def test_sensor_noise_does_not_depend_on_who_else_draws(either: Either) -> None:
    rng = np.random.default_rng(0)
    either.reset(stage_named("absent"), None, rng)
    state = rng.bit_generator.state
    either.step()
    assert rng.bit_generator.state == state


def test_an_observation_holds_sensors_only(either: Either) -> None:
    either.reset(stage_named("table_right"), None, np.random.default_rng(0))
    fields = {field.name for field in dataclasses.fields(either.observe())}
    assert fields == {"time", "positions", "velocities", "loads", "images", "regions"}


def test_asking_twice_changes_nothing(either: Either) -> None:
    either.reset(stage_named("noisy_right"), None, np.random.default_rng(0))
    assert _bytes(either.observe()) == _bytes(either.observe())


def test_an_observation_does_not_change_with_the_next_step(either: Either) -> None:
    either.reset(stage_named("table_right"), None, np.random.default_rng(0))
    before = either.observe()
    kept = _bytes(before)
    either.apply(before.positions + 0.05)
    either.step()
    assert _bytes(before) == kept
    assert _bytes(either.observe()) != kept


@pytest.mark.parametrize("rate", [30.0, 25.0, 15.0, 7.0])
def test_cameras_look_at_their_rate(make: type[Either], dexter: RobotDocument, rate: float) -> None:
    backend = make(with_vision(dexter, rate=rate), URDF)
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


@pytest.mark.parametrize("name", STAGES)
def test_every_context_of_every_shipped_stage_can_begin(make: type[Either], name: str) -> None:
    stage = stage_named(name)
    robot = robot_named(stage.robot)
    backend = make(robot, ROOT / "robots" / robot.model)
    for context, content in stage.contexts.items():
        assert backend.reset(stage, context, np.random.default_rng(1)) == context
        assert isinstance(backend, GroundTruthProvider)
        shown = set(backend.truth.names()) - set(stage.fixtures)
        assert len(shown) == bool(content.things)
        assert shown <= set(content.things)
        assert all(backend.truth.parts(thing) for thing in backend.truth.names())
        backend.step()
        assert not any(backend.truth.touched(thing) for thing in shown)
    backend.close()


@pytest.mark.parametrize(
    ("written", "instead", "complaint"),
    [
        ('name="pan"', 'name="neck"', "no revolute joint 'pan'"),
        ('name="right_finger_2_distal" type', 'name="x" type', "'right_finger_2_distal'"),
        ('"left_camera"', '"x"', "no link 'left_camera'"),
        ('"torso"', '"trunk"', "base 'torso'.*'trunk'"),
        ("</robot>", "", "cannot (be )?read"),
    ],
)
def test_a_model_that_does_not_fit_is_refused(
    make: type[Either],
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


def test_a_model_that_is_not_there_is_refused(
    make: type[Either], dexter: RobotDocument, tmp_path: Path
) -> None:
    with pytest.raises(BackendError, match=r"none\.urdf"):
        make(dexter, tmp_path / "none.urdf")
