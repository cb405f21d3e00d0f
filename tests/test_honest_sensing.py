"""Controllers read an observation and nothing else: no field and no method holds the truth."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import fields, is_dataclass, replace
from inspect import getmembers, isfunction
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import cbdsl
from cbdsl.backends.backend import Backend
from cbdsl.backends.bullet.backend import BulletBackend
from cbdsl.backends.kinematic.backend import KinematicBackend
from cbdsl.documents.robot import RobotDocument
from cbdsl.documents.stage import StageDocument
from cbdsl.kinematics.kinematics import Kinematics
from cbdsl.robot.channel_names import channel_names
from cbdsl.runtime.episode import Runner
from cbdsl.sensing.channels import Region
from cbdsl.sensing.observation import Observation
from tests.conftest import Checked

SENSORS = {"time", "positions", "velocities", "loads", "images", "regions", "efforts", "exposed"}


class Only:
    """Members of a backend in the protocol, without all others."""

    def __init__(self, backend: Backend) -> None:
        self.renderer = backend.renderer
        self.control_period = backend.control_period
        self.deadline = backend.deadline
        for name, _ in getmembers(Backend, isfunction):
            if not name.startswith("_"):
                setattr(self, name, getattr(backend, name))


def test_observation_has_sensors_only() -> None:
    assert is_dataclass(Observation)
    assert {field.name for field in fields(Observation)} == SENSORS


def test_observation_of_bullet_has_no_further_attributes(
    bullet: BulletBackend, dexter: RobotDocument, stage: Callable[[str], StageDocument]
) -> None:
    """Observations are of no subclass, and have no additional attribute."""
    bullet.reset(stage("table_right"), "in_view", np.random.default_rng(0))
    observation = bullet.observe()
    assert type(observation) is Observation
    assert not hasattr(observation, "__dict__")
    assert set(observation.images) == set(dexter.cameras)
    assert not observation.regions
    cells = {(hand, finger) for hand, found in dexter.load_cells.items() for finger in found}
    assert set(observation.loads) == cells
    assert observation.positions.shape == observation.velocities.shape == (24,)


def test_observation_of_the_kinematic_backend_has_no_further_attributes(
    dexter: RobotDocument, urdf: Path, stage: Callable[[str], StageDocument]
) -> None:
    """Regions hold only information that a channel's pixels contain."""
    backend = KinematicBackend(dexter, urdf)
    backend.reset(stage("table_right"), "in_view", np.random.default_rng(0))
    observation = backend.observe()
    assert type(observation) is Observation
    assert not hasattr(observation, "__dict__")
    assert not observation.images
    assert set(observation.regions) == set(dexter.cameras)
    channels = set(channel_names(dexter.vision.channels))
    for found in observation.regions.values():
        assert type(found) is dict and found
        assert set(found) <= channels, "no names of things"
        for region in (region for regions in found.values() for region in regions):
            assert type(region) is Region
            assert set(region._fields) == {"area", "column", "row", "clipped", "moments", "extent"}


def test_runtime_needs_nothing_but_the_protocol(
    bullet: BulletBackend,
    dexter: RobotDocument,
    kinematics: Kinematics,
    checked: Checked,
    stage: Callable[[str], StageDocument],
) -> None:
    wrapped = Only(bullet)
    assert set(vars(wrapped)) == {
        "renderer", "control_period", "deadline",
        "reset", "observe", "apply", "step", "halt", "close",
    }  # fmt: skip
    backends: list[Any] = [wrapped, bullet]
    results = [
        Runner(dexter, kinematics, checked("searchtrack"), backend).run(
            stage("table_in_view_right"), 3
        )
        for backend in backends
    ]
    bare, full = (replace(result, wall_seconds=0.0) for result in results)
    assert bare == full
    assert bare.rewarded


@pytest.mark.parametrize("layer", ["runtime", "control", "robot", "program"])
def test_layers_of_control_never_mention_the_simulator(layer: str) -> None:
    """Exclude also the truth, which only tests and the experimenter may read."""
    package = Path(cbdsl.__file__).parent / layer
    for file in package.rglob("*.py"):
        text = file.read_text(encoding="utf-8")
        assert "bullet" not in text.lower(), file
        assert "backends.kinematic" not in text.lower(), file
        assert ".truth" not in text, file
