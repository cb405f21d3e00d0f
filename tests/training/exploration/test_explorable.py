"""Explorable actions: their features, as they are when an action begins to act on them."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from cbdsl.backends.kinematic.backend import KinematicBackend
from cbdsl.documents.document_digest import ProgramDigest
from cbdsl.documents.robot import RobotDocument
from cbdsl.documents.stage import StageDocument
from cbdsl.kinematics.kinematics import Kinematics
from cbdsl.robot.resources import resources
from cbdsl.runtime.episode import Runner
from cbdsl.runtime.episode_observer import EpisodeListeners
from cbdsl.runtime.feature_reader import FeatureReader
from cbdsl.training.exploration.explorable import Explorable, explorable, other_hues
from tests.backends.conftest import stage_named
from tests.conftest import Checked

DIGEST = ProgramDigest("0" * 64, {}, {})


@pytest.fixture(scope="module")
def backend(dexter: RobotDocument, urdf: Path) -> KinematicBackend:
    return KinematicBackend(dexter, urdf)


@pytest.fixture
def action(checked: Checked, dexter: RobotDocument) -> Callable[..., Explorable]:
    def make(program: str, **values: str) -> Explorable:
        made = explorable(program, checked(program, **values), DIGEST, resources(dexter))
        assert made is not None
        return made

    return make


@pytest.mark.parametrize(
    ("program", "signals"),
    [
        ("searchtrack", ["left.sat_10", "left.sat_10.velocity", "left.sat_10.extent"]),
        ("reachtouch", ["stereo.sat_10", "stereo.sat_10.velocity", "stereo.sat_10.volume"]),
        ("bimanualtouch", ["stereo.sat_10", "stereo.sat_10.velocity", "stereo.sat_10.volume"]),
        ("visualinspect", ["stereo.sat_10", "stereo.sat_10.velocity", "stereo.sat_10.volume"]),
        ("touch_table", ["surface.green"]),
    ],
)
def test_features_belong_to_the_rewarded_signal(
    program: str, signals: list[str], action: Callable[[str], Explorable]
) -> None:
    own = action(program)
    assert [each.name for each in own.features.values()] == signals
    assert own.presence.name == f"left.{signals[0].partition('.')[2]}"


def test_features_of_a_mark_are_those_of_its_hue(action: Callable[..., Explorable]) -> None:
    own = action("visualinspect", mark="blue")
    signals = ["left.blue", "left.blue.velocity", "left.blue.extent"]
    assert [each.name for each in own.features.values()] == signals
    assert own.presence.name == "left.blue"


def test_program_without_a_heading_or_force_reward_is_not_explorable(
    checked: Checked, dexter: RobotDocument
) -> None:
    assert explorable("posture", checked("posture"), DIGEST, resources(dexter)) is None


@pytest.mark.parametrize("own", ["red", "hue_1"])
def test_other_hues_are_colours_and_the_hues_between_them(own: str, dexter: RobotDocument) -> None:
    hues = other_hues(dexter, {own, "sat_10"})
    assert hues == ["yellow", "green", "blue", "hue_2", "hue_3", "hue_6", "hue_9", "hue_10"]


def run(
    runner: Runner, stage: StageDocument, reader: FeatureReader, context: str | None = None
) -> None:
    runner.run(stage, 5, context, observer=EpisodeListeners(on_tick=reader.note_tick))


def test_features_are_read_before_the_touch(
    backend: KinematicBackend,
    dexter: RobotDocument,
    kinematics: Kinematics,
    action: Callable[[str], Explorable],
) -> None:
    own = action("reachtouch")
    runner = Runner(dexter, kinematics, own.program, backend, observed=own.observed)
    reader = FeatureReader(own.features, {"it": own.presence})
    run(runner, stage_named("table_right"), reader, "in_view")
    assert set(reader.values) == {"place", "velocity", "volume"}
    (name,) = [n for n in backend.truth.names() if backend.truth.objects[n].mass]
    item = backend.truth.objects[name]
    assert reader.values["place"] == pytest.approx(item.pose.position.tolist(), abs=0.02)
    assert reader.seconds["it"] > 0.5


def test_feature_of_a_surface_is_the_drawn_point(
    backend: KinematicBackend,
    dexter: RobotDocument,
    kinematics: Kinematics,
    action: Callable[[str], Explorable],
) -> None:
    own = action("touch_table")
    runner = Runner(dexter, kinematics, own.program, backend, observed=own.observed)
    reader = FeatureReader(own.features)
    run(runner, stage_named("bare_table"), reader, "in_view")
    x, y, z = reader.values["place"]
    assert 0.3 <= x <= 0.9 and -0.6 <= y <= 0.6 and np.isclose(z, -0.42, atol=0.02)
