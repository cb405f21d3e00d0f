"""Printed boxes look as their pattern says, in every renderer, and move as plain ones do."""

from __future__ import annotations

from typing import Any

import numpy as np
import pybullet as p
import pytest

from cbdsl.backends.bullet.backend import BulletBackend
from cbdsl.backends.cameras.view import View
from cbdsl.documents.robot import Camera
from cbdsl.documents.stage import StageDocument
from cbdsl.kinematics.pose import Pose
from tests.backends.conftest import made_stage

CAMERA = Camera(link="left_camera", width=400, height=300, focal_length=800)
CENTRE, EDGE, DISTANCE = np.array([3.0, 0.0, 0.0]), 0.16, 0.5
TURNS = {"-x": 0.0, "-y": np.pi / 2, "+x": np.pi, "+y": -np.pi / 2}


def _stage(color: tuple[float, float, float] = (1, 1, 1), **pattern: Any) -> StageDocument:
    form: dict[str, Any] = {"shape": "box", "size": [EDGE] * 3}
    if pattern:
        form["pattern"] = pattern
    thing = {"form": form, "mass": 0.3, "color": color}
    x, y, z = CENTRE
    context = {"things": ["box"], "place": {"x": x, "y": y, "z": z, "held": True}}
    return made_stage(context, things={"box": thing})


def _seen(backend: BulletBackend, stage: StageDocument, face: str) -> np.ndarray:
    """Return the brightness of the side ``face``, seen straight from outside, shape (300, 400)."""
    backend.reset(stage, None, np.random.default_rng(0))
    turned = Pose.turned(np.array([0.0, 0.0, 1.0]), TURNS[face])
    away = turned.rotation @ np.array([-DISTANCE - EDGE / 2, 0, 0])
    view = View(CAMERA, Pose(CENTRE + away, turned.rotation))
    image = backend.cameras.render({"eye": view})["eye"]
    return image.max(axis=2)


@pytest.mark.parametrize("face", TURNS)
def test_bars_go_from_left_to_right_at_their_widths(rendered: BulletBackend, face: str) -> None:
    stripes = [0.01, 0.005, 0.03, 0.02, 0.005]
    image = _seen(rendered, _stage(face=face, height=0.1, stripes=stripes), face)
    dark = image < 100
    columns = np.flatnonzero(np.diff(dark[150].astype(int))) + 1
    scale = CAMERA.focal_length / DISTANCE
    wanted = 200 + scale * (np.cumsum([0.0, *stripes]) - sum(stripes) / 2)
    assert columns == pytest.approx(wanted, abs=1.1)
    assert dark[:, columns[0] + 5].sum() == pytest.approx(0.1 * scale, abs=2)


@pytest.mark.parametrize("period", [0.002, 0.006, 0.03])
def test_stripes_have_their_period(rendered: BulletBackend, period: float) -> None:
    count = round(0.12 / period)
    stripes = [period / 2] * (2 * count - 1)
    image = _seen(rendered, _stage(height=0.1, stripes=stripes), "-x").astype(float)
    dark = (image[145:155] < 100).mean(axis=0)
    starts = np.flatnonzero((dark[1:] > 0.5) & (dark[:-1] <= 0.5))
    assert len(starts) == count
    measured = (starts[-1] - starts[0]) / (count - 1)
    assert measured == pytest.approx(CAMERA.focal_length * period / DISTANCE, rel=0.01)


def test_only_one_side_is_printed_on(rendered: BulletBackend) -> None:
    stage = _stage(face="-x", height=0.1, stripes=[0.1])
    for face in TURNS:
        dark = (_seen(rendered, stage, face) < 100).mean()
        assert (dark > 0.1) == (face == "-x")


def test_white_is_bright_where_the_robot_looks(rendered: BulletBackend) -> None:
    """White in front or on top is in the brightest of ten channels, other sides are not."""
    brightness = {face: _seen(rendered, _stage(), face)[150, 200] for face in TURNS}
    assert brightness.pop("-x") >= 0.9 * 256
    assert max(brightness.values()) < 0.9 * 256


def test_printed_box_has_the_mass_and_inertia_of_a_plain_one(blind: BulletBackend) -> None:
    dynamics = []
    for stage in (_stage(), _stage(height=0.1, stripes=[0.01] * 9)):
        blind.reset(stage, None, np.random.default_rng(0))
        client, body = blind.truth.client, blind.truth.bodies["box"]
        dynamics.append(p.getDynamicsInfo(body, -1, physicsClientId=client))
    assert dynamics[0] == dynamics[1]


@pytest.mark.parametrize("form", [{"shape": "ball"}, {"shape": "cylinder", "height": EDGE}])
def test_round_object_with_a_spot_has_the_mass_and_inertia_of_a_plain_one(
    blind: BulletBackend, form: dict[str, Any]
) -> None:
    dynamics = []
    for spot in ({}, {"spot": {"radius": 0.03, "color": (0, 0, 1)}}):
        x, y, z = CENTRE
        context = {"things": ["thing"], "place": {"x": x, "y": y, "z": z, "held": True}}
        spotted = {**form, "radius": EDGE / 2, **spot}
        stage = made_stage(context, things={"thing": {"form": spotted, "mass": 0.3}})
        blind.reset(stage, None, np.random.default_rng(0))
        client, body = blind.truth.client, blind.truth.bodies["thing"]
        dynamics.append(p.getDynamicsInfo(body, -1, physicsClientId=client))
    assert dynamics[0] == dynamics[1]


@pytest.mark.parametrize("face", TURNS)
@pytest.mark.parametrize(
    "form",
    [
        {"shape": "ball", "radius": 0.08},
        {"shape": "box", "size": [0.16] * 3},
        {"shape": "cylinder", "radius": 0.08, "height": 0.16},
    ],
)
def test_spot_is_round_and_on_its_side_alone(
    rendered: BulletBackend, form: dict[str, Any], face: str
) -> None:
    spot = {"face": face, "radius": 0.03, "color": (0, 0, 1)}
    x, y, z = CENTRE
    context = {"things": ["thing"], "place": {"x": x, "y": y, "z": z, "held": True}}
    things = {"thing": {"form": {**form, "spot": spot}, "mass": 0.3, "color": (1, 1, 0)}}
    stage = made_stage(context, things=things)
    for side in TURNS:
        rendered.reset(stage, None, np.random.default_rng(0))
        turned = Pose.turned(np.array([0.0, 0.0, 1.0]), TURNS[side])
        away = turned.rotation @ np.array([-DISTANCE - EDGE / 2, 0, 0])
        view = View(CAMERA, Pose(CENTRE + away, turned.rotation))
        image = rendered.cameras.render({"eye": view})["eye"]
        blue = image[..., 2].astype(int) - image[..., 0] > 20
        if side != face:
            # A spot on a curved side is seen a little from beside it.
            beside = form["shape"] != "box" and side[1] != face[1]
            assert beside or not blue.any()
            continue
        rows, columns = np.nonzero(blue)
        if form["shape"] == "ball" and "tiny" in rendered.renderer.lower():
            assert blue.mean() > 0.02  # its balls have corners
            continue
        # A ball's spot is as far away as its edge.
        nearer = 0.0 if form["shape"] == "box" else 0.08 - np.sqrt(0.08**2 - 0.03**2)
        across = 2 * 0.03 * CAMERA.focal_length / (DISTANCE + nearer)
        assert np.ptp(rows) == pytest.approx(across, rel=0.06)
        assert np.ptp(columns) == pytest.approx(across, rel=0.06)
        assert blue.sum() == pytest.approx(np.pi * across**2 / 4, rel=0.08)


def test_printed_fixture_does_not_fall(rendered: BulletBackend) -> None:
    form = {"shape": "box", "size": [EDGE] * 3, "pattern": {"height": 0.1, "stripes": [0.1]}}
    rendered.reset(
        made_stage({}, fixtures={"box": {"form": form, "position": [3, 0, 0]}}),
        None,
        np.random.default_rng(0),
    )
    for _ in range(5):
        rendered.step()
    assert rendered.truth.pose("box").position == pytest.approx(CENTRE)


def test_image_at_a_higher_resolution_shows_the_same_pattern(rendered: BulletBackend) -> None:
    rendered.reset(_stage(color=(1, 0, 0)), None, np.random.default_rng(0))
    coarse, fine = rendered.observe().images, rendered.cameras.resolve(3)
    for name, image in coarse.items():
        rows, columns, _ = image.shape
        assert fine[name].shape == (3 * rows, 3 * columns, 3)
        assert (fine[name][1::3, 1::3] == image).all(axis=2).mean() > 0.999
