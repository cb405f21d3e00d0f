"""Tubes and boxes without a lid: their contents, their visible parts and their contacts."""

from __future__ import annotations

import math

import numpy as np
import pytest

from cbdsl.backends.bullet.backend import BulletBackend
from cbdsl.backends.kinematic.backend import KinematicBackend
from cbdsl.backends.staging.shape import SolidShape
from cbdsl.documents.robot import RobotDocument
from cbdsl.documents.stage import StageDocument
from cbdsl.kinematics.pose import Pose
from cbdsl.numeric.convex import Convex, gap
from cbdsl.sensing.channels import ChannelFilter
from tests.backends.conftest import URDF, Simulated, made_stage, run, stage_named

SHAPES = {
    "tube": SolidShape.tube(0.06, 0.08, 0.01),
    "open_box": SolidShape.open_box(0.2, 0.16, 0.08, 0.01),
}


@pytest.mark.parametrize("name", SHAPES)
def test_walls_leave_the_inside_free_and_fill_the_rest(name: str) -> None:
    shape, pose = SHAPES[name], Pose(np.array([0.3, -0.1, 0.2]), np.eye(3))
    bodies = shape.bodies(pose)
    assert len(bodies) <= 16
    inside = {"tube": (0.05, 0.05), "open_box": (0.09, 0.07)}[name]

    def free(x: float, y: float, z: float) -> bool:
        at = Convex("ball", (1e-6,) * 3, pose.position + np.array([x, y, z]), np.eye(3))
        return all(gap(at, body) > 1e-5 for body in bodies)

    assert free(0, 0, 0.0) and free(0.98 * inside[0], 0, 0.0) and free(0, -0.98 * inside[1], 0.0)
    assert free(0, 0, -0.035) == (name == "tube"), "a box has a bottom"
    for angle in np.linspace(0, 2 * math.pi, 60):
        x, y = math.cos(angle), math.sin(angle)
        # Along a square of the half width for the box, which is half way into its wall.
        scale = (
            0.055 if name == "tube" else min(0.095 / max(abs(x), 1e-9), 0.075 / max(abs(y), 1e-9))
        )
        assert not free(scale * x, scale * y, 0.0)


def test_object_in_a_hollow_object_stays_inside(unseeing: Simulated) -> None:
    for context in ("in_tube", "in_tray", "beside"):
        unseeing.reset(stage_named("hollow"), context, np.random.default_rng(2))
        names = ("tube", "tray")
        start = {name: unseeing.truth.pose(name).position for name in names}
        run(unseeing, 1.0)
        ball = unseeing.truth.pose("ball").position
        for name in names:
            assert unseeing.truth.pose(name).position == pytest.approx(start[name], abs=2e-3)
        bottom = -0.42 + (0.01 if context == "in_tray" else 0.0)
        assert ball[2] == pytest.approx(bottom + 0.04, abs=2e-3)
        near = np.hypot(*(ball - unseeing.truth.pose("tube").position)[:2])
        assert (near < 0.011) == (context == "in_tube")


GUTTER = {
    "shape": "composed",
    "pieces": [
        {"form": {"shape": "box", "size": [0.16, 0.12, 0.02]}},
        {"form": {"shape": "box", "size": [0.02, 0.12, 0.06]}, "position": [0.07, 0, 0.04]},
        {"form": {"shape": "box", "size": [0.02, 0.12, 0.06]}, "position": [-0.07, 0, 0.04]},
        {
            "form": {"shape": "cylinder", "radius": 0.01, "height": 0.06},
            "position": [0, 0.05, 0.04],
        },
        {"form": {"shape": "ball", "radius": 0.01}, "position": [0, 0.05, 0.07]},
    ],
}


def gutter_with_a_ball(colour: tuple[float, ...] = (0, 0.4, 1)) -> StageDocument:
    """Return a stage with a composed object on a fixture, and a ball that is released in it."""
    bench = {"form": {"shape": "box", "size": [0.6, 1.2, 0.04]}, "position": [0.6, 0, -0.44]}
    ball = {"form": {"shape": "ball", "radius": 0.03}, "mass": 0.1}
    place = {"on": "bench", "x": [0.6, 0.6], "y": [-0.1, -0.1], "yaw": [0.3, 0.3]}
    placed = {
        "gutter": {"things": ["gutter"], "place": place},
        "ball": {"things": ["ball"], "place": {"on": "gutter", "y": [-0.03, -0.03]}},
    }
    joints = {"pan": -0.15, "tilt": 1.15}
    return made_stage(
        {"placed": placed, "joints": joints},
        fixtures={"bench": bench},
        things={"gutter": {"form": GUTTER, "mass": 0.4, "color": colour}, "ball": ball},
    )


def test_composed_object_rests_and_keeps_an_object_inside(unseeing: Simulated) -> None:
    unseeing.reset(gutter_with_a_ball(), None, np.random.default_rng(0))
    run(unseeing, 1.0)
    gutter, ball = unseeing.truth.pose("gutter"), unseeing.truth.pose("ball")
    # It is 9 cm high, the top of its ball included.
    assert gutter.position == pytest.approx([0.6, -0.1, -0.42 + 0.045], abs=3e-3)
    x, y, z = gutter.rotation.T @ (ball.position - gutter.position)
    assert abs(x) < 0.031 and abs(y) < 0.06
    assert z == pytest.approx(-0.045 + 0.02 + 0.03, abs=3e-3)


@pytest.mark.usefixtures("opengl")
def test_ideal_and_rendered_silhouettes_of_a_composed_object_agree(dexter: RobotDocument) -> None:
    hue = "hue_7"
    channels = ChannelFilter(dexter.vision.channels, [hue], least_area=4)
    rendered = BulletBackend(dexter, URDF, cameras="rendered")
    ideal = KinematicBackend(dexter, URDF)
    for backend in (rendered, ideal):
        backend.reset(gutter_with_a_ball(), None, np.random.default_rng(0))
    for camera, image in rendered.observe().images.items():
        (seen,) = channels.regions(image)[hue]
        (region,) = ideal.observe().regions[camera][hue]
        assert region.area == pytest.approx(seen.area, rel=0.06)
        assert (region.column, region.row) == pytest.approx((seen.column, seen.row), abs=1.5)
    rendered.close()
    ideal.close()


@pytest.mark.usefixtures("opengl")
def test_ideal_and_rendered_silhouettes_of_a_tube_agree(dexter: RobotDocument) -> None:
    """Walls of a tube are one region without the bore."""
    stage, hue = stage_named("hollow"), "hue_7"
    channels = ChannelFilter(dexter.vision.channels, [hue], least_area=4)
    rendered = BulletBackend(dexter, URDF, cameras="rendered")
    ideal = KinematicBackend(dexter, URDF)
    for seed in range(3):
        rendered.reset(stage, "in_tube", np.random.default_rng(seed))
        ideal.reset(stage, "in_tube", np.random.default_rng(seed))
        for camera, image in rendered.observe().images.items():
            (seen,) = channels.regions(image)[hue]
            (region,) = ideal.observe().regions[camera][hue]
            assert region.area == pytest.approx(seen.area, rel=0.06)
            assert (region.column, region.row) == pytest.approx((seen.column, seen.row), abs=1.0)
    rendered.close()
    ideal.close()


def test_fingertip_in_a_bore_touches_nothing_until_it_meets_the_wall(unseeing: Simulated) -> None:
    unseeing.reset(made_stage({}), None, np.random.default_rng(0))
    tip = unseeing.truth.link_pose("right_finger_1_tip").position
    form = {"shape": "tube", "radius": 0.06, "height": 0.04, "wall": 0.01}

    def touched(aside: float) -> bool:
        position = [float(tip[0]), float(tip[1]) + aside, float(tip[2])]
        stage = made_stage({}, fixtures={"ring": {"form": form, "position": position}})
        unseeing.reset(stage, None, np.random.default_rng(0))
        unseeing.step()
        return unseeing.truth.touched("ring")

    assert not touched(0.0)
    assert touched(0.055)
