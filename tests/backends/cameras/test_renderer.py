"""Every renderer draws the image of a pinhole camera, in the colours of the objects."""

from __future__ import annotations

from typing import Literal

import numpy as np
import pytest

from cbdsl.backends.backend import BackendError
from cbdsl.backends.bullet.backend import TinyRenderer
from cbdsl.backends.cameras import opengl
from cbdsl.backends.cameras.opengl import OpenGLRenderer
from cbdsl.backends.cameras.renderer import make_renderer
from cbdsl.backends.cameras.view import View
from cbdsl.documents.robot import Camera, RobotDocument
from cbdsl.documents.stage import StageDocument
from cbdsl.kinematics.pose import Pose
from cbdsl.robot.urdf import UrdfModel
from cbdsl.robot.urdf_reader import read_urdf
from tests.backends.conftest import BACKENDS, URDF, Simulated, made_stage, stage_named, with_vision

RADIUS = 0.07
GREENISH = (0.1, 0.8, 0.3)


def _stage(x: float, y: float, z: float) -> StageDocument:
    ball = {"form": {"shape": "ball", "radius": RADIUS}, "mass": 0.2, "color": GREENISH}
    context = {"things": ["ball"], "place": {"x": x, "y": y, "z": z}, "joints": {"tilt": 0.9}}
    return made_stage(context, things={"ball": ball})


def _saturation(image: np.ndarray) -> np.ndarray:
    bright, dark = image.max(axis=2).astype(float), image.min(axis=2)
    return 1 - dark / np.maximum(bright, 1)


def _ideal(view: View, centre: np.ndarray) -> np.ndarray:
    """Return a mask of fine samples that see the ball, shape (8 h, 8 w)."""
    camera, fine = view.camera, 8
    columns, rows = np.meshgrid(
        (np.arange(camera.width * fine) + 0.5) / fine,
        (np.arange(camera.height * fine) + 0.5) / fine,
    )
    across = (camera.width / 2 - columns) / camera.focal_length
    up = (camera.height / 2 - rows) / camera.focal_length
    rays = np.stack([np.ones_like(across), across, up], axis=-1)
    away = view.pose.rotation.T @ (centre - view.pose.position)
    along = rays @ away
    squared = (rays**2).sum(axis=-1)
    return (along > 0) & (along**2 >= squared * (away @ away - RADIUS**2))


def _centroid(mask: np.ndarray) -> np.ndarray:
    rows, columns = np.nonzero(mask)
    return np.array([columns.mean() + 0.5, rows.mean() + 0.5])


@pytest.mark.parametrize("place", [(0.7, 0.0, -0.1), (0.8, -0.15, -0.2), (0.75, 0.12, 0.0)])
def test_ball_is_drawn_at_its_pinhole_projection(
    rendered: Simulated, place: tuple[float, float, float]
) -> None:
    rendered.reset(_stage(*place), None, np.random.default_rng(0))
    images = rendered.observe().images
    for name, view in rendered.cameras.views().items():
        seen = _saturation(images[name]) > 0.5
        ideal = _ideal(view, np.array(place))
        assert seen.sum() > 500
        assert _centroid(seen) == pytest.approx(_centroid(ideal) / 8, abs=0.5)
        assert seen.sum() == pytest.approx(ideal.sum() / 64, rel=0.1)


def test_shading_keeps_hue_and_saturation(rendered: Simulated) -> None:
    rendered.reset(_stage(0.7, 0.0, -0.1), None, np.random.default_rng(0))
    image = rendered.observe().images["left"]
    ball = image[_saturation(image) > 0.5].astype(float)
    assert np.ptp(ball[:, 1]) > 20
    assert ball / ball[:, 1:2] == pytest.approx(
        np.broadcast_to(np.array(GREENISH) / GREENISH[1], ball.shape), abs=0.02
    )


def test_only_objects_are_saturated_in_images(rendered: Simulated) -> None:
    posture = {
        "pan": -0.25,
        "tilt": 1.15,
        "right_arm_1": 0.44,
        "right_arm_2": -1.58,
        "right_arm_3": 0.58,
        "right_arm_4": 2.07,
        "right_arm_5": -2.21,
    }
    rendered.reset(made_stage({"joints": posture}), None, np.random.default_rng(0))
    for image in rendered.observe().images.values():
        assert _saturation(image).max() < 0.05
        assert np.ptp(image) > 100, "the robot's own arm is in view"


def test_first_row_is_the_top_and_the_first_column_is_left(rendered: Simulated) -> None:
    camera = Camera(link="left_camera", width=64, height=48, focal_length=50)
    view = View(camera, Pose(np.array([5.0, 0, 0]), np.eye(3)))
    for y, z, rows, columns in [(0.5, 0, slice(None), slice(32)), (0, 0.4, slice(24), slice(None))]:
        rendered.reset(_stage(7.0, y, z), None, np.random.default_rng(0))
        image = rendered.cameras.render({"eye": view})["eye"]
        seen = _saturation(image) > 0.5
        assert seen.any()
        assert seen[rows, columns].sum() == seen.sum()


def test_removed_thing_is_gone_from_the_images(rendered: Simulated) -> None:
    stage = _stage(0.7, 0.0, -0.1)
    context = stage.contexts["only"].model_copy(update={"removed_after": 0.02})
    rendered.reset(
        stage.model_copy(update={"contexts": {"only": context}}), None, np.random.default_rng(0)
    )
    assert (_saturation(rendered.observe().images["left"]) > 0.5).any()
    for _ in range(8):
        rendered.step()
    assert not (_saturation(rendered.observe().images["left"]) > 0.5).any()


def _fail(model: UrdfModel) -> OpenGLRenderer:
    raise BackendError("libEGL.so.1 cannot be loaded")


def test_without_opengl_auto_takes_the_simulators_own(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(opengl, "OpenGLRenderer", _fail)
    model, tiny = read_urdf(URDF), TinyRenderer(0)
    assert make_renderer("auto", model, {"tiny": lambda: tiny}) is tiny
    with pytest.raises(BackendError, match=r"libEGL\.so\.1.*libegl1.*'auto' and 'tiny' do"):
        make_renderer("opengl", model, {"tiny": lambda: tiny})
    with pytest.raises(BackendError, match=r"libEGL\.so\.1.*ideal cameras do without"):
        make_renderer("auto", model, {})


@pytest.mark.parametrize(("kind", "owner"), [("tiny", "bullet"), ("mujoco", "mujoco")])
def test_another_engines_renderer_is_refused(kind: Literal["tiny", "mujoco"], owner: str) -> None:
    with pytest.raises(BackendError, match=rf"only the {owner} backend.*'auto' and 'opengl'"):
        make_renderer(kind, read_urdf(URDF), {})


@pytest.mark.parametrize("is_spotted", [False, True])
def test_mujoco_renderer_agrees_with_the_shared_renderer(
    is_spotted: bool, dexter: RobotDocument
) -> None:
    """Draw the same shapes in the same light; only the corners of round shapes differ."""
    stage, images = stage_named("things_on_table"), []
    if is_spotted:
        content = stage.model_dump(mode="json")
        spot = {"face": "-x", "radius": 0.02, "color": (0, 0, 1)}
        can = {"shape": "cylinder", "radius": 0.05, "height": 0.1, "spot": spot}
        for thing in content["things"].values():
            thing["form"] = can
        stage = StageDocument.model_validate(content)
    for kind in ("opengl", "mujoco"):
        try:
            backend = BACKENDS["mujoco"](with_vision(dexter, renderer=kind), URDF)
        except BackendError as error:
            pytest.skip(str(error))
        backend.reset(stage, "light_box", np.random.default_rng(3))
        images.append(backend.observe().images["left"].astype(int))
        backend.close()
    assert (_saturation(images[0]) > 0.9).sum() > (200 if is_spotted else 1000)
    assert (np.abs(images[0] - images[1]).max(axis=2) > 2).mean() < 0.001
