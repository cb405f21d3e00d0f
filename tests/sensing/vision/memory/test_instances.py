"""Instances: several things of one colour are kept apart, and remembered where the head looks away.

On the kinematic backend, whose ideal cameras see them as rendered ones do.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from cbdsl.backends.backend import Backend, embody
from cbdsl.backends.kinematic.backend import KinematicBackend
from cbdsl.documents.robot import Regions, RobotDocument
from cbdsl.documents.stage import StageDocument
from cbdsl.kinematics.kinematics import Kinematics
from cbdsl.kinematics.pose import Pose
from cbdsl.numeric.arrays import Floats
from cbdsl.robot.instance_names import instance_names, parse_instance
from cbdsl.robot.resources import resources
from cbdsl.sensing.signals import Signals
from cbdsl.sensing.vision.memory.instances import Instances
from cbdsl.sensing.vision.regions.field_of_view import FieldOfView
from tests.sensing.vision.association.test_sighting import sighting

RED = "red"
LEFT, RIGHT = np.array([0.6, 0.07, -0.36]), np.array([0.62, -0.08, -0.37])
AHEAD, AWAY = {"pan": 0.0, "tilt": 1.15}, {"pan": 1.2, "tilt": 0.3}


class Scene:
    """Red balls without a support, and a robot that looks at them.

    Attributes:
        backend: Backend with the balls, by the names ``ball_0`` and on.
        signals: Signals of the robot.
    """

    def __init__(self, robot: RobotDocument, urdf: Path, backend: Backend | None = None) -> None:
        self.backend = backend or KinematicBackend(robot, urdf)
        self._named = resources(robot)
        wanted = [self._named["stereo.red"]]
        self.signals = Signals(robot, Kinematics(robot, urdf), wanted)

    def show(self, *balls: tuple[Floats, float], **joints: float) -> None:
        """Begin anew with balls, each a centre and a radius."""
        fixtures = {
            f"ball_{number}": {
                "form": {"shape": "ball", "radius": radius},
                "position": centre.tolist(),
                "color": [1, 0, 0],
            }
            for number, (centre, radius) in enumerate(balls)
        }
        document: dict[str, Any] = {
            "cbdsl": 1, "kind": "stage", "name": "balls", "robot": "dexter",
            "fixtures": fixtures, "contexts": {"all": {"joints": joints or AHEAD}},
        }  # fmt: skip
        stage = StageDocument.model_validate(document)
        self.backend.reset(stage, None, np.random.default_rng(0))
        self.signals.reset()
        self._reference = self.backend.observe().positions.copy()

    def look(self, seconds: float = 0.3, **joints: float) -> None:
        """Let time pass, with the head turning to these joints."""
        for name, angle in joints.items():
            self._reference[self.signals.joints.index[name]] = angle
        for _ in range(round(seconds / self.backend.control_period)):
            self.signals.update(self.backend.observe())
            self.backend.apply(self._reference)
            self.backend.step()

    @property
    def red(self) -> Instances:
        return self.signals.vision.instances[RED]

    def places(self) -> dict[int, Floats]:
        """Return remembered positions by number."""
        return {
            number: memory.position
            for number, memory in enumerate(self.red.memories)
            if memory.position is not None
        }

    def value(self, name: str) -> Floats | None:
        """Return the value of a resource, also of an instance's."""
        resource = self._named.get(name)
        if resource is None:
            parsed = parse_instance(name, self._named)
            assert parsed is not None
            resource = parsed.resource(name)
        reading = self.signals.read(resource)
        return None if reading is None else reading.value


@pytest.fixture(scope="module")
def scene(dexter: RobotDocument, urdf: Path) -> Iterator[Scene]:
    scene = Scene(dexter, urdf)
    yield scene
    scene.backend.close()


def near(place: Floats) -> Any:
    return pytest.approx(place, abs=0.005)


def test_two_of_one_hue_have_a_place_each_and_the_larger_is_attended_to(scene: Scene) -> None:
    scene.show((LEFT, 0.04), (RIGHT, 0.06))
    scene.look()
    assert scene.places() == {0: near(RIGHT), 1: near(LEFT)}
    assert scene.value("stereo.red") == near(RIGHT)
    assert scene.value("stereo.red.1") == near(RIGHT)
    assert scene.value("stereo.red.2") == near(LEFT)
    assert scene.value("stereo.red.3") is None


def test_how_many_are_remembered_is_counted(scene: Scene) -> None:
    scene.show((LEFT, 0.05), (RIGHT, 0.06))
    assert scene.value("count.red") is None, "before the first image"
    scene.look()
    assert scene.value("count.red") == 2
    scene.look(2.0, **AWAY)
    assert scene.value("count.red") == 2, "out of view, and remembered"
    scene.backend.truth.remove("ball_1")
    scene.look(3.0, **AHEAD)
    assert scene.value("count.red") == 1
    assert parse_instance("count.red.2", resources(scene.signals.robot)) is None


def test_selections_choose_among_remembered_instances(scene: Scene) -> None:
    scene.show((LEFT, 0.04), (RIGHT, 0.06))
    scene.look()
    expected = {
        "leftmost": LEFT, "rightmost": RIGHT, "largest": RIGHT, "nearest": LEFT, "other": LEFT,
    }  # fmt: skip
    for selection, place in expected.items():
        assert scene.value(f"stereo.red.{selection}") == near(place), selection


def test_headings_lead_to_the_instance_and_never_between(scene: Scene) -> None:
    scene.show((LEFT, 0.05), (RIGHT, 0.05))
    scene.look()
    for name, place in (("leftmost", LEFT), ("rightmost", RIGHT)):
        for camera in ("left", "right"):
            frame = scene.signals.kinematics.frame(f"{camera}_camera")
            x, y, _ = frame.rotation.T @ (place - frame.position)
            angles = scene.value(f"{camera}.red.{name}")
            assert angles is not None
            assert angles[0] == pytest.approx(math.atan2(y, x), abs=0.01)


def test_attention_moves_on_only_when_its_thing_is_forgotten(scene: Scene) -> None:
    scene.show((LEFT, 0.05), (RIGHT, 0.06))
    scene.look()
    assert scene.value("stereo.red") == near(RIGHT)
    scene.backend.truth.remove("ball_1")
    scene.look(1.0)
    assert scene.value("stereo.red") == near(LEFT)
    assert scene.value("stereo.red.1") is None
    assert scene.value("stereo.red.2") == near(LEFT)


def test_instance_out_of_view_is_remembered_with_its_number(scene: Scene) -> None:
    scene.show((LEFT, 0.05), (RIGHT, 0.06))
    scene.look()
    before = scene.places()
    scene.look(10.0, **AWAY)
    assert not any(scene.red.sightings)
    assert scene.places() == {number: near(place) for number, place in before.items()}
    scene.look(2.0, **AHEAD)
    assert scene.places() == {number: near(place) for number, place in before.items()}


def test_removed_instance_is_forgotten_once_its_place_is_in_view(scene: Scene) -> None:
    scene.show((LEFT, 0.05), (RIGHT, 0.06))
    scene.look()
    scene.look(3.0, **AWAY)
    scene.backend.truth.remove("ball_1")
    scene.look(3.0)
    assert len(scene.places()) == 2
    scene.look(1.0, **AHEAD)
    scene.look(1.0)
    assert list(scene.places().values()) == [near(LEFT)]


def test_new_object_does_not_get_the_number_of_one_out_of_view(scene: Scene) -> None:
    """Recognize a second object: the first has not moved."""
    aside = np.array([0.45, 0.5, -0.36])
    scene.show((RIGHT, 0.05), (aside, 0.05))
    scene.look()
    assert scene.places() == {0: near(RIGHT)}
    scene.look(3.0, pan=1.2, tilt=1.0)
    assert scene.places() == {0: near(RIGHT), 1: near(aside)}
    assert scene.value("stereo.red") == near(RIGHT)


def test_carried_object_hides_another_instance(scene: Scene) -> None:
    eyes = np.array([0.287, 0.0, 0.51])
    front, aside = eyes + 0.75 * (RIGHT - eyes), np.array([0.56, 0.08, -0.2])
    scene.show((RIGHT, 0.03), (aside, 0.07))
    scene.look()
    assert len(scene.places()) == 2
    (behind,) = (number for number, place in scene.places().items() if place == near(RIGHT))
    truth = scene.backend.truth
    for share in np.linspace(0.0, 1.0, 40):
        truth.put_back("ball_1", Pose(aside + share * (front - aside), np.eye(3)))
        scene.look(0.1)
    scene.look(5.0)
    assert behind not in scene.red.sightings[0] and behind not in scene.red.sightings[1]
    assert scene.places() == {behind: near(RIGHT), 1 - behind: near(front)}
    truth.remove("ball_0")
    for share in np.linspace(1.0, 0.0, 40):
        truth.put_back("ball_1", Pose(aside + share * (front - aside), np.eye(3)))
        scene.look(0.1)
    scene.look(1.0)
    assert scene.places() == {1 - behind: near(aside)}


def test_instances_with_merged_regions_keep_their_places(scene: Scene) -> None:
    """Merge regions: the joint one is little larger than the large one, its middle off by a cm."""
    large = np.array([0.6, -0.08, -0.36])
    aside, beside = (large + np.array([0.0, apart, 0.0]) for apart in (0.125, 0.108))
    scene.show((large, 0.07), (aside, 0.04))
    scene.look()
    assert scene.places() == {0: near(large), 1: near(aside)}
    truth = scene.backend.truth
    truth.put_back("ball_1", Pose(beside, np.eye(3)))
    scene.look()
    assert all(len(seen["red"]) == 1 for seen in scene.signals.vision.seen.values())
    scene.look(5.0)
    assert scene.places() == {0: near(large), 1: near(aside)}
    truth.remove("ball_1")
    scene.look(2.0)
    assert scene.places() == {0: near(large)}


@pytest.mark.parametrize("hidden", [True, False])
def test_parts_of_an_instance_beside_a_hand_are_no_new_instance(
    scene: Scene, monkeypatch: pytest.MonkeyPatch, hidden: bool
) -> None:
    """Without a hand before it, the lines of sight to two parts of it meet at a ghost."""
    scene.show((RIGHT, 0.06))
    scene.look()
    vision, red = scene.signals.vision, scene.red
    parts = []
    for (camera, eye), aside in zip(scene.signals.robot.cameras.items(), (12, -12), strict=True):
        whole, frame = vision.seen[camera][RED][0], scene.signals.kinematics.frame(eye.link)
        half = whole._replace(area=whole.area // 2)
        rest = whole._replace(area=whole.area // 4, column=whole.column + aside)
        parts.append([vision._sighted(camera, frame, each) for each in (half, rest)])
    monkeypatch.setattr(vision.field, "is_hidden_by_hand", lambda position: hidden)
    for tick in range(1, 5):
        red.look(1.0 + tick / 15, 1.0 + tick / 15, parts)
    assert len(scene.places()) == (1 if hidden else 2)
    assert scene.places()[0] == near(RIGHT)


@pytest.mark.parametrize("alike", [False, True])
def test_parts_of_an_instance_beside_a_forearm_do_not_move_it(
    scene: Scene, monkeypatch: pytest.MonkeyPatch, alike: bool
) -> None:
    """Show another part of it to each camera; the lines of sight meet away from all hands.

    Two parts of one size look like a smaller object that has moved there.
    """
    scene.show((RIGHT, 0.06))
    scene.look()
    vision, red = scene.signals.vision, scene.red
    parts, areas = [], (8, 8) if alike else (8, 2)
    eyes = zip(scene.signals.robot.cameras.items(), (16, -16), areas, strict=True)
    for (camera, eye), aside, eighths in eyes:
        whole, frame = vision.seen[camera][RED][0], scene.signals.kinematics.frame(eye.link)
        part = whole._replace(area=whole.area * eighths // 16, column=whole.column + aside)
        parts.append([vision._sighted(camera, frame, part)])
    monkeypatch.setattr(
        vision.field, "is_hidden_by_hand", lambda place: math.dist(place, RIGHT) < 0.06
    )
    for tick in range(1, 5):
        red.look(1.0 + tick / 15, 1.0 + tick / 15, parts)
    assert (scene.places()[0] == near(RIGHT)) is not alike


@pytest.mark.parametrize("side", [1, -1], ids=["left", "right"])
def test_instance_occluded_by_a_shoulder_does_not_move(
    dexter: RobotDocument, urdf: Path, side: int
) -> None:
    """Turn the head to a near object aside, so that one camera looks over the shoulder."""
    aside, pan = np.array([0.32, side * 0.58, -0.36]), side * 1.44
    scene = Scene(dexter, urdf, embody("mujoco", dexter, urdf, cameras="rendered"))
    camera = "left" if side > 0 else "right"
    scene.show((aside, 0.06), pan=side, tilt=1.02)
    scene.look()
    whole = scene.signals.vision.seen[camera][RED][0].area
    scene.look(1.0, pan=pan, tilt=1.02)
    assert scene.signals.vision.seen[camera][RED][0].area < 0.7 * whole
    assert scene.places() == {0: near(aside)}
    scene.backend.close()


def test_instance_is_discovered_only_without_an_occluding_hand(
    scene: Scene, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Hide an object in part: the middle of its region wanders as the hand goes."""
    scene.show((LEFT, 0.04), (RIGHT, 0.06))
    with monkeypatch.context() as patched:
        patched.setattr(
            FieldOfView, "is_hidden_by_hand", lambda _, place: math.dist(place, RIGHT) < 0.1
        )
        scene.look()
        assert scene.places() == {0: near(LEFT)}
    scene.look()
    assert scene.places() == {0: near(LEFT), 1: near(RIGHT)}


def test_thing_that_is_moved_keeps_its_number(scene: Scene) -> None:
    scene.show((LEFT, 0.05), (RIGHT, 0.06))
    scene.look()
    truth = scene.backend.truth
    ball = truth.objects["ball_1"]
    truth.remove("ball_1")
    moved = RIGHT + np.array([0.0, -0.05, 0.15])
    truth.add(ball._replace(pose=Pose(moved, ball.pose.rotation)))
    scene.look(1.0)
    assert scene.places() == {0: near(moved), 1: near(LEFT)}


def test_every_name_of_an_instance_names_a_resource(dexter: RobotDocument) -> None:
    named = resources(dexter)
    names = instance_names(dexter)
    assert names[:4] == ("1", "2", "3", "4")
    for name in names:
        for base in ("left.red", "cyclopean.red", "cameras.red", "stereo.red"):
            parsed = parse_instance(f"{base}.{name}", named)
            assert parsed is not None
            resource = parsed.resource(f"{base}.{name}")
            assert resource.type == named[base].type
            assert resource.source.instance == name
    volume = parse_instance("stereo.red.2.volume", named)
    assert volume is not None and volume.base == named["stereo.red.volume"]
    assert parse_instance("right_arm.position", named) is None
    one_eyed = dexter.model_copy(update={"cameras": {"left": dexter.cameras["left"]}})
    assert instance_names(one_eyed) == ()


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_clipped_instance_has_headings_without_a_position(scene: Scene, side: float) -> None:
    """Give it the lowest free number in both images, beside one that both see whole."""
    middle, aside = np.array([0.56, 0.0, -0.36]), np.array([0.7, 0.34 * side, -0.36])
    scene.show((middle, 0.05), (aside, 0.04))
    scene.look()
    assert list(scene.places()) == [0] and scene.places()[0] == near(middle)
    for sightings in scene.red.sightings:
        assert sorted(sightings) == [0, 1]
        assert sightings[0].distance(middle) < 0.005
        assert sightings[1].distance(aside) < 0.02


def test_one_camera_alone_attends_to_the_largest(
    dexter: RobotDocument, kinematics: Kinematics
) -> None:
    """Without positions there is one heading, and nothing to remember."""
    alone = Instances(Regions(), FieldOfView(dexter, kinematics), 1)
    large, small = sighting(300), sighting(40)
    alone.look(0.0, 0.0, [[large, small]])
    assert alone.sightings == [{0: large}] and alone.memories == ()
    alone.look(0.1, 0.1, [[small]])
    assert alone.sightings == [{0: small}]
    alone.look(0.2, 0.2, [[]])
    assert alone.sightings == [{}]
