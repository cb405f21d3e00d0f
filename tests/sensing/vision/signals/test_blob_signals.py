"""Velocity, volume, extent and orientation of visible objects, against the simulator's truth."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from pathlib import Path

import numpy as np
import pytest

from cbdsl.backends.backend import embody
from cbdsl.documents.robot import RobotDocument
from cbdsl.documents.stage import StageDocument
from cbdsl.kinematics.kinematics import Kinematics
from cbdsl.robot.resources import resources
from cbdsl.sensing.signals import Signals
from cbdsl.sensing.table.reading import Reading

PARTS = ("velocity", "extent", "orientation")
NAMES = (*(f"left.red.{part}" for part in PARTS), "stereo.red.velocity", "stereo.red.volume")
StageNamed = Callable[[str], StageDocument]


class Watcher:
    """Looks with a robot that keeps still."""

    def __init__(self, kind: str, dexter: RobotDocument, urdf: Path, kinematics: Kinematics):
        engine = {"rendered": "bullet", "ideal": "kinematic"}[kind]
        self.backend = embody(engine, dexter, urdf, cameras=kind)
        self._named = {name: resources(dexter)[name] for name in (*NAMES, "stereo.red")}
        self.signals = Signals(dexter, kinematics, self._named.values())

    def look(self, stage: StageDocument, seed: int, seconds: float) -> Mapping[str, Reading | None]:
        """Return the readings after some time of an episode."""
        backend, signals = self.backend, self.signals
        context = "in_view" if "in_view" in stage.contexts else None
        backend.reset(stage, context, np.random.default_rng(seed))
        signals.reset()
        for _ in range(1 + round(seconds / backend.control_period)):
            signals.update(backend.observe())
            backend.apply(signals.positions.copy())
            backend.step()
        return {name: signals.read(resource) for name, resource in self._named.items()}


@pytest.fixture(params=["rendered", "ideal"])
def watcher(
    request: pytest.FixtureRequest, dexter: RobotDocument, urdf: Path, kinematics: Kinematics
):
    made = Watcher(request.param, dexter, urdf, kinematics)
    yield made
    made.backend.close()


def test_moving_thing_has_its_velocity_in_space_and_in_the_image(
    watcher: Watcher, stage: StageNamed
) -> None:
    moved = watcher.look(stage("moving_right"), 1, 0.8)
    velocity, image = moved["stereo.red.velocity"], moved["left.red.velocity"]
    assert velocity is not None and image is not None
    assert np.linalg.norm(velocity.value) == pytest.approx(0.05, abs=0.005)
    angle = math.degrees(math.atan2(velocity.value[1], velocity.value[0]))
    assert 70 < angle < 110
    # It glides to the left, and nearer: down in the image.
    assert image.value[0] == pytest.approx(0.042, abs=0.01) and image.value[1] < -0.01
    at_first = watcher.look(stage("moving_right"), 1, 0.0)
    assert at_first["stereo.red"] is not None
    assert at_first["stereo.red.velocity"] is None and at_first["left.red.velocity"] is None


def test_resting_ball_has_no_velocity_and_its_volume(watcher: Watcher, stage: StageNamed) -> None:
    only_ball = stage("table_in_view_right").model_copy(
        update={"things": {"ball": stage("table_in_view_right").things["ball"]}}
    )
    context = only_ball.contexts["in_view"].model_copy(update={"things": ("ball",)})
    only_ball = only_ball.model_copy(update={"contexts": {"in_view": context}})
    compared = 0
    for seed in range(5):
        seen = watcher.look(only_ball, seed, 0.6)
        position, volume = seen["stereo.red"], seen["stereo.red.volume"]
        assert (position is None) == (volume is None)
        if position is None or volume is None:
            continue
        (ball,) = [each for each in watcher.backend.truth.objects.values() if each.name == "ball"]
        radius = ball.shape.halves[0]
        assert volume.value[0] == pytest.approx(4 / 3 * math.pi * radius**3, rel=0.08)
        velocity, extent = seen["stereo.red.velocity"], seen["left.red.extent"]
        assert velocity is not None and np.abs(velocity.value).max() < 0.01
        assert extent is not None and seen["left.red.orientation"] is None
        compared += 1
    assert compared >= 2


def test_blob_signals_of_an_unseen_object_are_undefined(
    watcher: Watcher, stage: StageNamed
) -> None:
    assert not any(watcher.look(stage("absent"), 0, 0.3).values())
