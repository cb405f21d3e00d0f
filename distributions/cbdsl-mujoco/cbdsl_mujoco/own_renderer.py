"""Images by MuJoCo's own renderer, with the same shapes and light as those of cbdsl."""

from __future__ import annotations

import ctypes
from collections.abc import Iterator, Sequence
from ctypes import byref, c_int, c_uint, c_void_p
from typing import Any

import mujoco as mj
import numpy as np
from numpy.typing import NDArray

from cbdsl.extend.backend import (
    AMBIENT,
    DIRECTION,
    FARTHEST,
    NEAREST,
    BackendError,
    Engine,
    Image,
    Part,
    Pose,
    RobotDocument,
    UrdfModel,
    UrdfShape,
    View,
)

# EGL's numbers: the platform without a window system, and desktop OpenGL.
_SURFACELESS, _OPENGL = 0x31DD, 0x30A2


class OffscreenContext:
    """OpenGL context by EGL, in the profile in which MuJoCo draws.

    Raises:
        OSError: EGL is missing, or cannot draw without a window.
    """

    def __init__(self) -> None:
        self._egl = _library()
        self._display = self._egl.eglGetPlatformDisplay(_SURFACELESS, None, None)
        major, minor = c_int(), c_int()
        if not self._egl.eglInitialize(self._display, byref(major), byref(minor)):
            raise OSError("EGL cannot be initialised without a window")
        self._context = None
        if self._egl.eglBindAPI(_OPENGL):
            self._context = self._egl.eglCreateContext(self._display, None, None, None)
        if not self._context:
            raise OSError("EGL offers no OpenGL without a window")

    def __enter__(self) -> None:
        if not self._egl.eglMakeCurrent(self._display, None, None, self._context):
            raise OSError("the OpenGL context cannot be made current")

    def __exit__(self, *_: object) -> None:
        self._egl.eglMakeCurrent(self._display, None, None, None)

    def close(self) -> None:
        """Free the context."""
        self._egl.eglDestroyContext(self._display, self._context)


def _library() -> Any:
    """Return the library EGL, with the types of the functions that are called."""
    egl = ctypes.CDLL("libEGL.so.1")
    egl.eglGetPlatformDisplay.restype = egl.eglCreateContext.restype = c_void_p
    egl.eglGetPlatformDisplay.argtypes = [c_uint, c_void_p, c_void_p]
    egl.eglInitialize.argtypes = [c_void_p, c_void_p, c_void_p]
    egl.eglBindAPI.argtypes = [c_uint]
    egl.eglCreateContext.argtypes = egl.eglMakeCurrent.argtypes = [c_void_p] * 4
    egl.eglDestroyContext.argtypes = [c_void_p] * 2
    return egl


_KINDS = {
    "ball": mj.mjtGeom.mjGEOM_SPHERE,
    "box": mj.mjtGeom.mjGEOM_BOX,
    "cylinder": mj.mjtGeom.mjGEOM_CYLINDER,
}
# Grey of 0.78, as in the OpenGL renderer.
_BACKGROUND = 199
# Colour of links without a colour in the model.
_GREY = (0.7, 0.7, 0.7)
# Largest number of shapes in a scene.
_SHAPES = 2000


class MujocoRenderer:
    """Renderer by MuJoCo with OpenGL, without shadows and highlights, which change hues.

    Args:
        robot: Robot document with the cameras, whose largest images have to fit.
        model: URDF model of the robot.

    Raises:
        BackendError: OpenGL without a window is missing, or the robot has a shape that cannot be
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
        """Return images of robot and objects from each view; see ``Renderer.render``."""
        self._show(engine)
        with self._context:
            self._make_room(views)
            return [self._image(view) for view in views]

    def _make_room(self, views: Sequence[View]) -> None:
        """Enlarge the offscreen buffer until each view fits."""
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
        # The scene has a camera for each eye, and a mono image takes their average.
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
    """Return a model of nothing, with room for the largest image and one sample a pixel."""
    spec = mj.MjSpec()
    spec.visual.global_.offwidth = max(each.width for each in robot.cameras.values())
    spec.visual.global_.offheight = max(each.height for each in robot.cameras.values())
    spec.visual.quality.offsamples = 0
    # Enough slices for balls whose regions have the right size.
    spec.visual.quality.numslices, spec.visual.quality.numstacks = 96, 48
    return spec.compile()


def _light(scene: Any) -> None:
    """Set the light of all renderers, and switch off all effects that change colours."""
    for flag in ("SHADOW", "REFLECTION", "SKYBOX", "FOG", "HAZE"):
        scene.flags[getattr(mj.mjtRndFlag, f"mjRND_{flag}")] = False
    scene.nlight = 1
    lamp = scene.lights[0]
    lamp.type = mj.mjtLightType.mjLIGHT_DIRECTIONAL
    # MuJoCo states the direction in which light travels.
    lamp.dir = [-each for each in DIRECTION]
    lamp.ambient, lamp.diffuse = [AMBIENT] * 3, [1.0 - AMBIENT] * 3
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
    """Set a shape of the scene to that of a part."""
    a, b, c = (*part.size, 0.0, 0.0)[:3]
    sizes = {"ball": [a, a, a], "box": [a / 2, b / 2, c / 2], "cylinder": [a, b / 2, 0.0]}
    size, color = np.array(sizes[part.shape]), np.array([*part.color, 1.0], dtype=np.float32)
    mj.mjv_initGeom(geom, _KINDS[part.shape], size, place.position, place.rotation.ravel(), color)
    geom.specular = geom.shininess = geom.reflectance = geom.emission = 0.0


def _look(camera: Any, view: View) -> None:
    """Move a camera of the scene to a view."""
    # Half of the image's height, h / (2 f) per distance, at the nearest plane. The width follows
    # from the viewport.
    opening = NEAREST * view.camera.height / (2.0 * view.camera.focal_length)
    axes = view.pose.rotation
    camera.pos, camera.forward, camera.up = view.pose.position, axes[:, 0], axes[:, 2]
    camera.frustum_center, camera.orthographic = 0.0, 0
    camera.frustum_bottom, camera.frustum_top = -opening, opening
    camera.frustum_near, camera.frustum_far = NEAREST, FARTHEST


def _is_empty(depth: NDArray[np.float32]) -> NDArray[np.bool_]:
    """Return the pixels without a shape; MuJoCo may count depth from either end."""
    empty: NDArray[np.bool_] = (depth >= 1.0) | (depth <= 0.0)
    return empty
