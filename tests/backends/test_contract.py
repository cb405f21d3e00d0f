"""The contract of every backend that can be used: observations, limits of time, and the halt."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator
from itertools import count
from pathlib import Path

import numpy as np
import pytest

from cbdsl.backends.backend import Backend, embody
from cbdsl.documents.robot import RobotDocument
from cbdsl.kinematics.kinematics import Kinematics
from cbdsl.robot.joints import Joints
from cbdsl.runtime.episode import DeadlineError, Runner
from cbdsl.sensing.observation import Observation
from tests.backends.conftest import SELF_CONTAINED, sightless, stage_named
from tests.conftest import Checked


@pytest.fixture(scope="module", params=SELF_CONTAINED)
def name(request: pytest.FixtureRequest) -> str:
    return str(request.param)


@pytest.fixture(scope="module")
def backend(name: str, dexter: RobotDocument, urdf: Path) -> Iterator[Backend]:
    backend = embody(name, dexter, urdf)
    yield backend
    backend.close()


def episode(backend: Backend, seed: int, steps: int = 24) -> list[bytes]:
    """Return all observations of an episode in which the arms move towards the table."""
    backend.reset(stage_named("noisy_right"), None, np.random.default_rng(seed))
    observed = []
    reference = backend.observe().positions
    for _ in range(steps):
        observed.append(as_bytes(backend.observe()))
        reference = reference + 0.01
        backend.apply(reference)
        backend.step()
    return observed


def as_bytes(observation: Observation) -> bytes:
    arrays = [observation.positions, observation.velocities]
    arrays += [*observation.loads.values(), *observation.images.values()]
    regions = repr({camera: dict(seen) for camera, seen in observation.regions.items()})
    return b"".join(np.ascontiguousarray(array).tobytes() for array in arrays) + regions.encode()


def begin(backend: Backend, stage: str = "table_right") -> Observation:
    backend.reset(stage_named(stage), None, np.random.default_rng(0))
    return backend.observe()


def test_same_seed_gives_same_bytes_after_any_run(
    name: str, backend: Backend, dexter: RobotDocument, urdf: Path
) -> None:
    first = episode(backend, 3)
    episode(backend, 4)
    assert episode(backend, 3) == first
    other = embody(name, dexter, urdf)
    assert episode(other, 3) == first
    other.close()


def test_reset_begins_the_given_context_of_the_stage(backend: Backend) -> None:
    stage = stage_named("table_right")
    for context in stage.contexts:
        assert backend.reset(stage, context, np.random.default_rng(0)) == context
    assert backend.reset(stage, None, np.random.default_rng(0)) in stage.contexts


def test_an_observation_holds_sensors_only(backend: Backend, dexter: RobotDocument) -> None:
    observation = begin(backend)
    fields = {field.name for field in dataclasses.fields(observation)}
    assert fields == {
        "time", "positions", "velocities", "efforts", "loads", "images", "regions", "exposed",
    }  # fmt: skip
    joints = len(Joints(dexter).names)
    assert observation.time == 0.0
    assert observation.positions.shape == observation.velocities.shape == (joints,)
    hands = dexter.load_cells.items()
    assert list(observation.loads) == [(hand, cell) for hand, cells in hands for cell in cells]
    assert {wrench.shape for wrench in observation.loads.values()} == {(6,)}


def test_observe_twice_returns_the_same_observation(backend: Backend) -> None:
    assert as_bytes(begin(backend, "noisy_right")) == as_bytes(backend.observe())


def test_an_observation_does_not_change_with_the_next_step(backend: Backend) -> None:
    before = begin(backend)
    kept = as_bytes(before)
    backend.apply(before.positions + 0.05)
    backend.step()
    assert as_bytes(before) == kept
    assert as_bytes(backend.observe()) != kept
    assert backend.observe().time == pytest.approx(backend.control_period)


def test_halted_robot_keeps_its_positions(name: str, dexter: RobotDocument, urdf: Path) -> None:
    backend = embody(name, sightless(dexter), urdf)
    before = begin(backend, "absent").positions
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
    name: str, dexter: RobotDocument, urdf: Path
) -> None:
    backend = embody(name, sightless(dexter), urdf)
    backend.halt()
    begin(backend, "absent")
    rng = np.random.default_rng(0)
    with pytest.raises(BaseException):  # noqa: B017
        backend.reset(None, None, rng)  # type: ignore[arg-type]
    backend.halt()
    backend.close()


def test_a_late_tick_freezes_its_references(
    name: str,
    dexter: RobotDocument,
    urdf: Path,
    kinematics: Kinematics,
    checked: Checked,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    backend = embody(name, sightless(dexter), urdf)
    assert backend.deadline is None or backend.deadline > 0.0
    backend.deadline = 1.5
    halts: list[None] = []
    halt = backend.halt
    monkeypatch.setattr(backend, "halt", lambda: (halts.append(None), halt()))
    # Each look at the clock is a second after the one before, and from the sixth on two.
    clock = (float(n + max(n - 6, 0)) for n in count())
    runner = Runner(dexter, kinematics, checked("posture"), backend, clock=lambda: next(clock))
    with pytest.raises(DeadlineError, match="deadline is 1500 ms; references are frozen"):
        runner.run(stage_named("absent"), 0)
    assert len(halts) == 1
    backend.close()
