"""The backend's contract: the same seed gives the same episode, and only sensors are seen."""

from __future__ import annotations

import dataclasses
from pathlib import Path

import numpy as np
import pytest

from cbdsl.backends.backend import BackendError
from cbdsl.backends.bullet.backend import BulletBackend
from cbdsl.documents.robot import RobotDocument
from cbdsl.documents.stage import StageDocument
from cbdsl.robot.joints import Joints
from cbdsl.robot.observation import Observation
from tests.backends.bullet.conftest import LIBRARY, URDF, made_stage, stage_named, with_vision

STAGES = LIBRARY.names(StageDocument)


def _episode(backend: BulletBackend, seed: int, steps: int = 24) -> list[bytes]:
    """All that is observed of an episode in which the arms move towards the table."""
    rng = np.random.default_rng(seed)
    backend.reset(stage_named("noisy_right"), None, rng)
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
    return b"".join(np.ascontiguousarray(array).tobytes() for array in arrays)


def test_same_seed_same_bytes_whatever_ran_before(
    backend: BulletBackend, dexter: RobotDocument
) -> None:
    first = _episode(backend, 3)
    assert _episode(backend, 4) != first
    assert _episode(backend, 3) == first
    other = BulletBackend(dexter, URDF)
    assert _episode(other, 3) == first
    other.close()


def test_sensor_noise_does_not_depend_on_who_else_draws(blind: BulletBackend) -> None:
    rng = np.random.default_rng(0)
    blind.reset(stage_named("absent"), None, rng)
    state = rng.bit_generator.state
    blind.step()
    assert rng.bit_generator.state == state


def test_an_observation_holds_sensors_only(backend: BulletBackend) -> None:
    backend.reset(stage_named("table_right"), None, np.random.default_rng(0))
    fields = {field.name for field in dataclasses.fields(backend.observe())}
    assert fields == {"time", "positions", "velocities", "loads", "images", "regions"}


def test_asking_twice_changes_nothing(backend: BulletBackend) -> None:
    backend.reset(stage_named("noisy_right"), None, np.random.default_rng(0))
    assert _bytes(backend.observe()) == _bytes(backend.observe())


@pytest.mark.parametrize("rate", [30.0, 25.0, 15.0, 7.0])
def test_images_come_at_their_rate(dexter: RobotDocument, rate: float) -> None:
    backend = BulletBackend(with_vision(dexter, rate=rate), URDF)
    backend.reset(stage_named("absent"), None, np.random.default_rng(0))
    times = []
    for _ in range(round(dexter.control.rate)):
        if backend.observe().images:
            times.append(backend.observe().time)
        backend.step()
    backend.close()
    assert times[0] == 0
    assert len(times) == rate
    assert np.diff(times) == pytest.approx(1 / rate, abs=backend.control_period + 1e-9)


@pytest.mark.parametrize("name", STAGES)
def test_every_context_of_every_shipped_stage_can_begin(backend: BulletBackend, name: str) -> None:
    stage = stage_named(name)
    for context, content in stage.contexts.items():
        assert backend.reset(stage, context, np.random.default_rng(1)) == context
        shown = set(backend.truth.names()) - set(stage.fixtures)
        assert len(shown) == bool(content.things)
        assert shown <= set(content.things)
        assert not any(backend.truth.touched(thing) for thing in shown)


def test_nothing_stays_from_one_episode_to_the_next(backend: BulletBackend) -> None:
    rng = np.random.default_rng(0)
    for _ in range(3):
        backend.reset(stage_named("table_right"), None, rng)
        assert len(backend.truth.names()) == 2
    backend.reset(stage_named("absent"), None, rng)
    assert backend.truth.names() == ("table",)
    assert not _reddish(backend.observe()).any()


def _reddish(observation: Observation) -> np.ndarray:
    pixels = np.stack(list(observation.images.values())).astype(int)
    return (pixels[..., 0] > 60) & (pixels[..., 1] < 10)


def test_contexts_are_drawn_by_their_shares(blind: BulletBackend) -> None:
    stage = made_stage({"share": 3}).model_copy()
    stage = StageDocument.model_validate(
        {**stage.model_dump(), "contexts": {"often": {"share": 3}, "seldom": {"share": 1}}}
    )
    rng = np.random.default_rng(0)
    drawn = [blind.reset(stage, None, rng) for _ in range(40)]
    assert 22 <= drawn.count("often") <= 38


def test_joints_start_in_their_postures_or_where_the_context_says(
    blind: BulletBackend, dexter: RobotDocument
) -> None:
    blind.reset(made_stage({"joints": {"pan": [0.2, 0.3]}}), None, np.random.default_rng(0))
    start = blind.observe().positions
    joints = Joints(dexter)
    assert 0.2 <= start[joints.index["pan"]] <= 0.3
    for name, effector in dexter.effectors.items():
        assert effector.start is not None
        for joint, angle in zip(effector.joints, effector.postures[effector.start], strict=True):
            if joint != "pan":
                assert start[joints.index[joint]] == pytest.approx(angle), name


def test_joints_follow_their_references(blind: BulletBackend) -> None:
    blind.reset(made_stage({}), None, np.random.default_rng(0))
    start = blind.observe().positions
    goal = start + np.where(start > 0, -0.2, 0.2)
    steps = round(0.5 / blind.control_period)
    for share in np.linspace(0, 1, steps):
        blind.apply(start + share * (goal - start))
        blind.step()
    for _ in range(steps):
        blind.step()
    assert blind.observe().positions == pytest.approx(goal, abs=0.01)
    assert blind.observe().time == pytest.approx(2 * steps * blind.control_period)


def test_unknown_names_are_told_with_the_known_ones(blind: BulletBackend) -> None:
    rng = np.random.default_rng(0)
    with pytest.raises(BackendError, match=r"'nowhere'.*only"):
        blind.reset(made_stage({}), "nowhere", rng)
    with pytest.raises(BackendError, match="no actuated joint 'elbow'"):
        blind.reset(made_stage({"joints": {"elbow": 0}}), None, rng)
    with pytest.raises(BackendError, match="thing 'cup'; there is: none"):
        blind.reset(made_stage({"things": ["cup"], "place": {"z": 0}}), None, rng)
    ball = {"form": {"shape": "ball", "radius": 0.05}, "mass": 0.2}
    place = {"things": ["ball"], "place": {"on": "shelf"}}
    with pytest.raises(BackendError, match="fixture 'shelf'"):
        blind.reset(made_stage(place, things={"ball": ball}), None, rng)
    place = {"things": ["ball"], "place": {"hand": "head", "gap": 0.02}}
    with pytest.raises(BackendError, match="'head', which has no tip"):
        blind.reset(made_stage(place, things={"ball": ball}), None, rng)


def test_the_physics_rate_must_be_a_multiple_of_the_control_rate(dexter: RobotDocument) -> None:
    simulation = dexter.simulation.model_copy(update={"physics_rate": 200.0})
    robot = dexter.model_copy(update={"simulation": simulation})
    with pytest.raises(BackendError, match=rf"200 Hz.*multiple.*{dexter.control.rate:g} Hz"):
        BulletBackend(robot, URDF)


@pytest.mark.parametrize(
    ("written", "instead", "complaint"),
    [
        ('name="pan"', 'name="neck"', "no revolute joint 'pan'"),
        ('name="right_finger_2_distal" type', 'name="x" type', "'right_finger_2_distal'"),
        ('"left_camera"', '"x"', "no link 'left_camera'"),
        ('"torso"', '"trunk"', "base 'torso'.*'trunk'"),
        ("</robot>", "", "cannot read"),
    ],
)
def test_a_model_that_does_not_fit_is_refused(
    dexter: RobotDocument, tmp_path: Path, written: str, instead: str, complaint: str
) -> None:
    text = URDF.read_text()
    assert written in text
    urdf = tmp_path / "broken.urdf"
    urdf.write_text(text.replace(written, instead))
    with pytest.raises(BackendError, match=complaint):
        BulletBackend(dexter, urdf)


def test_a_model_that_is_not_there_is_refused(dexter: RobotDocument, tmp_path: Path) -> None:
    with pytest.raises(BackendError, match=r"none\.urdf"):
        BulletBackend(dexter, tmp_path / "none.urdf")
