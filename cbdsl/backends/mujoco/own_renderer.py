"""Images by MuJoCo's own renderer, of the same shapes and in the same light as by ours."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

import mujoco as mj
import numpy as np
from numpy.typing import NDArray

from cbdsl.backends.backend import BackendError
from cbdsl.backends.cameras import light
from cbdsl.backends.cameras.view import FARTHEST, NEAREST, View
from cbdsl.backends.mujoco.offscreen_context import OffscreenContext
from cbdsl.backends.staging.engine import Engine
from cbdsl.backends.staging.pose import Pose
from cbdsl.backends.staging.world_state import Part
from cbdsl.documents.robot import RobotDocument
from cbdsl.robot.urdf import UrdfModel, UrdfShape
from cbdsl.sensing.observation import Image

_KINDS = {
    "ball": mj.mjtGeom.mjGEOM_SPHERE,
    "box": mj.mjtGeom.mjGEOM_BOX,
    "cylinder": mj.mjtGeom.mjGEOM_CYLINDER,
}
_BACKGROUND = 199
# Of links whose model gives no colour.
_GREY = (0.7, 0.7, 0.7)
# Most shapes in a scene.
_SHAPES = 2000


class MujocoRenderer:
    """Renders with MuJoCo, by OpenGL, without shadows and highlights, which would change hues.

    Args:
        robot: names the cameras, whose largest images have to fit.
        model: its URDF.

    Raises:
        BackendError: there is no OpenGL without a window, or the robot has a shape that cannot be
            drawn.
    """

    name = "mujoco (MuJoCo's own renderer)"

    def __init__(self, robot: RobotDocument, model: UrdfModel) -> None:
        self._robot = [
            (link.name, _part(shape, model))
            for link in model.bodies.values()
            for shape in link.visuals
        ]
        empty = _empty_model(robot)
        try:
            self._context = OffscreenContext()
        except OSError as error:
            raise BackendError(
                f"MuJoCo cannot make the images ({error}); on Debian and Ubuntu it needs the "
                "packages libegl1, libgl1 and libgl1-mesa-dri; ideal cameras do without"
            ) from error
        with self._context:
            self._drawing = mj.MjrContext(empty, mj.mjtFontScale.mjFONTSCALE_100)
            mj.mjr_setBuffer(mj.mjtFramebuffer.mjFB_OFFSCREEN, self._drawing)
        self._scene = mj.MjvScene(empty, _SHAPES)
        _light(self._scene)

    def render(self, engine: Engine, views: Sequence[View]) -> list[Image]:
        """Robot and objects as they are now, from each view; see ``Renderer.render``."""
        self._show(engine)
        with self._context:
            self._make_room(views)
            return [self._image(view) for view in views]

    def _make_room(self, views: Sequence[View]) -> None:
        """Enlarge the picture that is drawn to until each view fits."""
        room = self._drawing.offWidth, self._drawing.offHeight
        width = max(room[0], *(view.camera.width for view in views))
        height = max(room[1], *(view.camera.height for view in views))
        if (width, height) != room:
            mj.mjr_resizeOffscreen(width, height, self._drawing)

    def _show(self, engine: Engine) -> None:
        """Put robot and objects into the scene."""
        count = 0
        for frame, part in self._parts(engine):
            if part.shape not in _KINDS:
                raise BackendError(
                    f"MuJoCo's own renderer draws no {part.shape}; the renderer 'opengl' does"
                )
            place = frame @ Pose.of(part.position, part.quaternion)
            _set_shape(self._scene.geoms[count], part, place)
            count += 1
        self._scene.ngeom = count

    def _parts(self, engine: Engine) -> Iterator[tuple[Pose, Part]]:
        for link, part in self._robot:
            yield engine.link_pose(link), part
        for name in engine.names():
            pose = engine.pose(name)
            yield from ((pose, part) for part in engine.parts(name))

    def _image(self, view: View) -> Image:
        width, height = view.camera.width, view.camera.height
        for camera in self._scene.camera:
            _look(camera, view)
        area = mj.MjrRect(0, 0, width, height)
        image = np.empty((height, width, 3), dtype=np.uint8)
        depth: NDArray[np.float32] = np.empty((height, width), dtype=np.float32)
        mj.mjr_render(area, self._scene, self._drawing)
        mj.mjr_readPixels(image, depth, area, self._drawing)
        image[_is_empty(depth)] = _BACKGROUND
        # OpenGL's first row is the lowest.
        return np.ascontiguousarray(image[::-1])

    def close(self) -> None:
        """Free the context and everything in it."""
        with self._context:
            self._drawing.free()
        self._context.close()


def _empty_model(robot: RobotDocument) -> Any:
    """A model of nothing, with room for the largest image and one sample a pixel."""
    spec = mj.MjSpec()
    spec.visual.global_.offwidth = max(each.width for each in robot.cameras.values())
    spec.visual.global_.offheight = max(each.height for each in robot.cameras.values())
    spec.visual.quality.offsamples = 0
    # Balls whose patches are as large as they should be.
    spec.visual.quality.numslices, spec.visual.quality.numstacks = 96, 48
    return spec.compile()


def _light(scene: Any) -> None:
    """The light of all renderers, and nothing that changes colours."""
    for flag in ("SHADOW", "REFLECTION", "SKYBOX", "FOG", "HAZE"):
        scene.flags[getattr(mj.mjtRndFlag, f"mjRND_{flag}")] = False
    scene.nlight = 1
    lamp = scene.lights[0]
    lamp.type = mj.mjtLightType.mjLIGHT_DIRECTIONAL
    lamp.dir = [-each for each in light.DIRECTION]
    lamp.ambient, lamp.diffuse = [light.AMBIENT] * 3, [1.0 - light.AMBIENT] * 3
    lamp.specular, lamp.castshadow, lamp.headlight = [0.0] * 3, False, False


def _part(shape: UrdfShape, model: UrdfModel) -> Part:
    if shape.kind not in _KINDS:
        raise BackendError(
            f"{model.path.name}: MuJoCo's own renderer draws no {shape.kind}; ideal cameras need "
            "no renderer"
        )
    at = shape.origin
    return Part(shape.kind, shape.size, at.xyz, at.quaternion, shape.color or _GREY)


def _set_shape(geom: Any, part: Part, place: Pose) -> None:
    """Make a shape of the scene a part."""
    a, b, c = (*part.size, 0.0, 0.0)[:3]
    size = {"ball": [a, a, a], "box": [a / 2, b / 2, c / 2], "cylinder": [a, b / 2, 0.0]}[
        part.shape
    ]
    color = np.array([*part.color, 1.0], dtype=np.float32)
    mj.mjv_initGeom(
        geom,
        _KINDS[part.shape],
        np.array(sizes[part.shape]),
        place.position,
        place.rotation.ravel(),
        color,
    )
    geom.specular = geom.shininess = geom.reflectance = geom.emission = 0.0


def _look(camera: Any, view: View) -> None:
    """Put a camera of the scene where a view is from."""
    opening = NEAREST * view.camera.height / (2.0 * view.camera.focal_length)
    axes = view.pose.rotation
    camera.pos, camera.forward, camera.up = view.pose.position, axes[:, 0], axes[:, 2]
    camera.frustum_center, camera.orthographic = 0.0, 0
    camera.frustum_bottom, camera.frustum_top = -opening, opening
    camera.frustum_near, camera.frustum_far = NEAREST, FARTHEST


def _is_empty(depth: NDArray[np.float32]) -> NDArray[np.bool_]:
    """Where nothing was drawn; MuJoCo may count depth from either end."""
    empty: NDArray[np.bool_] = (depth >= 1.0) | (depth <= 0.0)
    return empty
