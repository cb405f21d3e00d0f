"""Contract of backends: observations, seeds, limits of speed and time, and the halt."""

from __future__ import annotations

import dataclasses
import os
from collections.abc import Iterator
from itertools import count
from pathlib import Path

import numpy as np
import pytest

from cbdsl.api.reading.robots import read_robot
from cbdsl.backends.backend import BACKENDS, Backend, embody
from cbdsl.backends.engines import installed_engines
from cbdsl.checking.program import check_program
from cbdsl.documents.robot import RobotDocument
from cbdsl.documents.stage import StageDocument
from cbdsl.kinematics.kinematics import Kinematics
from cbdsl.numeric.arrays import Floats, Image
from cbdsl.robot.joints import Joints
from cbdsl.robot.urdf_reader import read_urdf
from cbdsl.runtime.episode import DeadlineError, Runner
from cbdsl.sensing.observation import Observation
from cbdsl.yaml_text.library import Library

ROBOT = os.environ.get("CBDSL_ROBOT", "dexter")
#: Backends that need no person beside them.
NAMES = [
    *installed_engines(),
    *(
        name
        for name in BACKENDS.usable_names()
        if name not in installed_engines()
        and not BACKENDS.is_builtin(name)
        and not hasattr(BACKENDS.get(name), "attend")
    ),
]
EMPTY = {"cbdsl": 1, "kind": "stage", "name": "empty", "contexts": {"only": {}}}
# Fingers that push one another exceed the speed of their servos by 6 percent: the error that a
# solver leaves after its iterations.
FASTER = 1.1

Body = tuple[RobotDocument, Path]


@pytest.fixture(scope="module", params=NAMES)
def name(request: pytest.FixtureRequest) -> str:
    return str(request.param)


@pytest.fixture(scope="module")
def body() -> Body:
    return read_robot(ROBOT)


@pytest.fixture(scope="module")
def blind(body: Body) -> Body:
    """Return the robot with exact sensors and no images."""
    robot, urdf = body
    exact = {"noise": 0.0, "bias": 0.0, "drift": 0.0}
    effectors = {
        key: effector.model_copy(update={"resolution": 0.0})
        for key, effector in robot.effectors.items()
    }
    update = {"cameras": {}, "contact": robot.contact.model_copy(update=exact)}
    return robot.model_copy(update={**update, "effectors": effectors}), urdf


@pytest.fixture(scope="module")
def stage(body: Body) -> StageDocument:
    """Return a stage with objects and noise, or an empty one for another robot than Dexter."""
    if body[0].name != "dexter":
        return StageDocument.model_validate({**EMPTY, "robot": body[0].name})
    library = Library()
    return library.read(library.locate(StageDocument, "noisy_right"), StageDocument).document


@pytest.fixture(scope="module")
def backend(name: str, body: Body) -> Iterator[Backend]:
    backend = embody(name, *body)
    yield backend
    backend.close()


def as_bytes(observation: Observation) -> bytes:
    """Return all measurements of an observation."""
    arrays: list[Floats | Image] = [observation.positions, observation.velocities]
    arrays += [*observation.loads.values(), *observation.images.values()]
    regions = repr({camera: dict(seen) for camera, seen in observation.regions.items()})
    return b"".join(np.ascontiguousarray(array).tobytes() for array in arrays) + regions.encode()


def begin(backend: Backend, stage: StageDocument, seed: int = 0) -> Observation:
    backend.reset(stage, None, np.random.default_rng(seed))
    return backend.observe()


def episode(backend: Backend, stage: StageDocument, seed: int) -> list[bytes]:
    """Return all observations of an episode in which all joints move."""
    reference, observed = begin(backend, stage, seed).positions, []
    for _ in range(24):
        observed.append(as_bytes(backend.observe()))
        reference = reference + 0.01
        backend.apply(reference)
        backend.step()
    return observed


def test_equal_seeds_give_equal_bytes_after_any_run(
    name: str, backend: Backend, body: Body, stage: StageDocument
) -> None:
    first = episode(backend, stage, 3)
    episode(backend, stage, 4)
    assert episode(backend, stage, 3) == first
    other = embody(name, *body)
    assert episode(other, stage, 3) == first
    other.close()


def test_reset_begins_the_given_context_of_the_stage(
    backend: Backend, stage: StageDocument
) -> None:
    for context in stage.contexts:
        assert backend.reset(stage, context, np.random.default_rng(0)) == context
    assert backend.reset(stage, None, np.random.default_rng(0)) in stage.contexts


def test_observation_holds_sensors_only_in_their_shapes(
    backend: Backend, body: Body, stage: StageDocument
) -> None:
    observation, robot = begin(backend, stage), body[0]
    fields = {field.name for field in dataclasses.fields(observation)}
    assert fields == {
        "time", "positions", "velocities", "efforts", "loads", "images", "regions", "exposed",
    }  # fmt: skip
    joints = len(Joints(robot).names)
    assert observation.time == 0.0
    assert observation.positions.shape == observation.velocities.shape == (joints,)
    hands = robot.load_cells.items()
    assert list(observation.loads) == [(hand, cell) for hand, cells in hands for cell in cells]
    assert {wrench.shape for wrench in observation.loads.values()} <= {(6,)}


def test_observe_twice_returns_the_same_observation(backend: Backend, stage: StageDocument) -> None:
    assert as_bytes(begin(backend, stage)) == as_bytes(backend.observe())


def test_observation_stays_unchanged_by_the_next_step(
    backend: Backend, stage: StageDocument
) -> None:
    before = begin(backend, stage)
    kept = as_bytes(before)
    backend.apply(before.positions + 0.05)
    backend.step()
    assert as_bytes(before) == kept
    assert as_bytes(backend.observe()) != kept
    assert backend.observe().time == pytest.approx(backend.control_period)


def test_references_past_the_limits_move_joints_within_their_speeds(name: str, blind: Body) -> None:
    backend = embody(name, *blind)
    begin(backend, StageDocument.model_validate({**EMPTY, "robot": blind[0].name}))
    joints = [read_urdf(blind[1]).joints[joint] for joint in Joints(blind[0]).names]
    speeds, largest = np.zeros(len(joints)), np.array([joint.velocity for joint in joints])
    for end in ([joint.upper + 1 for joint in joints], [joint.lower - 1 for joint in joints]):
        backend.apply(np.array(end))
        for _ in range(round(0.6 / backend.control_period)):
            backend.step()
            speeds = np.maximum(speeds, np.abs(backend.observe().velocities))
    backend.close()
    assert (speeds <= FASTER * largest).all(), (speeds / largest).round(3)
    assert (speeds > 0.5 * largest).any(), "no joint is driven to its limit"


def test_halted_robot_keeps_its_positions(name: str, blind: Body) -> None:
    backend = embody(name, *blind)
    stage = StageDocument.model_validate({**EMPTY, "robot": blind[0].name})
    before = begin(backend, stage).positions
    backend.apply(before + 0.5)
    backend.step()
    backend.halt()
    halted = backend.observe().positions
    assert abs(halted - before).max() > 1e-3
    for _ in range(round(0.5 / backend.control_period)):
        backend.step()
    assert backend.observe().positions == pytest.approx(halted, abs=0.03)
    backend.close()


def test_halt_before_the_first_episode_and_in_a_broken_reset_does_nothing(
    name: str, blind: Body
) -> None:
    backend = embody(name, *blind)
    backend.halt()
    begin(backend, StageDocument.model_validate({**EMPTY, "robot": blind[0].name}))
    with pytest.raises(BaseException):  # noqa: B017
        backend.reset(None, None, np.random.default_rng(0))  # type: ignore[arg-type]
    backend.halt()
    backend.close()


@pytest.mark.skipif(ROBOT != "dexter", reason="the program is for Dexter")
def test_late_tick_freezes_the_references(
    name: str, blind: Body, monkeypatch: pytest.MonkeyPatch
) -> None:
    backend = embody(name, *blind)
    assert backend.deadline is None or backend.deadline > 0.0
    backend.deadline = 1.5
    halts: list[str] = []
    halt = backend.halt

    def counted() -> None:
        halts.append("halt")
        halt()

    monkeypatch.setattr(backend, "halt", counted)
    # Each reading of the clock is a second after the one before, and from the sixth on two.
    clock = (float(n + max(n - 6, 0)) for n in count())
    program = check_program("posture")
    runner = Runner(blind[0], Kinematics(*blind), program, backend, clock=lambda: next(clock))
    with pytest.raises(DeadlineError, match="deadline is 1500 ms; references are frozen"):
        runner.run(StageDocument.model_validate({**EMPTY, "robot": "dexter"}), 0)
    assert len(halts) == 1
    backend.close()
