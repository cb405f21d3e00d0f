"""Selection of a camera system, independent of the engine."""

from __future__ import annotations

from collections.abc import Callable, Mapping

from cbdsl.backends.backend import BackendError
from cbdsl.backends.cameras.camera_system import CameraSystem
from cbdsl.backends.cameras.ideal import IdealCameras
from cbdsl.backends.cameras.rendered import RenderedCameras
from cbdsl.backends.cameras.renderer import NoRenderer, Renderer, make_renderer
from cbdsl.documents.robot import RobotDocument
from cbdsl.robot.urdf import UrdfModel


def make_cameras(
    kind: str | None,
    robot: RobotDocument,
    model: UrdfModel,
    own: Mapping[str, Callable[[], Renderer]] | None = None,
) -> CameraSystem:
    """Return the camera system of a robot.

    Args:
        kind: ``rendered`` or ``ideal``; rendered if ``None``, or ideal if rendering fails here and
            the robot file requests no renderer.
        robot: Robot document, which names the cameras.
        model: URDF model of the robot.
        own: Factories of the engine's own renderers, by name, if it has any.

    Raises:
        BackendError: No renderer works here.
    """
    if kind is None and robot.vision.renderer == "auto":
        try:
            return make_cameras("rendered", robot, model, own)
        except BackendError:
            cameras = IdealCameras(robot, model)
            cameras.renderer = f"{cameras.renderer}, since OpenGL is missing"
            return cameras
    if kind == "ideal":
        return IdealCameras(robot, model)
    if not robot.cameras:
        return RenderedCameras(robot, NoRenderer())
    renderer = make_renderer(robot.vision.renderer, model, own or {})
    return RenderedCameras(robot, renderer)
