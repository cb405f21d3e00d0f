"""Images by OpenGL without a window: all shapes as instances of unit meshes or own meshes."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import moderngl
import numpy as np
from numpy.typing import NDArray

from cbdsl.backends.backend import BackendError
from cbdsl.backends.cameras import light
from cbdsl.backends.cameras import primitive_mesh as mesh
from cbdsl.backends.cameras.view import View
from cbdsl.backends.staging.engine import Engine
from cbdsl.backends.staging.solids import POSITION, ROTATION
from cbdsl.backends.staging.world_state import Part
from cbdsl.kinematics.quaternion import rotations
from cbdsl.numeric.arrays import Floats, Image
from cbdsl.robot.meshes.mesh_file import find_mesh
from cbdsl.robot.meshes.mesh_reader import Mesh
from cbdsl.robot.meshes.simplified_mesh import read_simplified
from cbdsl.robot.urdf import UrdfModel, UrdfShape

BACKGROUND = (0.78, 0.78, 0.78)
# Colour of links without a colour in the model.
_GREY = (0.7, 0.7, 0.7)

# Light and shade multiply a colour, so that its hue and saturation stay.
# Normals are scaled like corners, although in general they need the inverse transpose. That is
# exact here: balls and meshes scale evenly, and the normals of boxes and cylinders lie along or
# across the scaled axes.
_VERTEX_SHADER = """
#version 330
in vec3 corner; in vec3 normal;
in vec4 column_0; in vec4 column_1; in vec4 column_2; in vec4 column_3; in vec3 color;
uniform mat4 world_to_clip;
out vec3 world_normal; flat out vec3 base_color;
void main() {
    mat4 mesh_to_world = mat4(column_0, column_1, column_2, column_3);
    gl_Position = world_to_clip * mesh_to_world * vec4(corner, 1);
    world_normal = mat3(mesh_to_world) * normal;
    base_color = color;
}
"""
_FRAGMENT_SHADER = """
#version 330
in vec3 world_normal; flat in vec3 base_color;
out vec4 shaded;
uniform vec3 light; uniform float ambient;
void main() {
    float direct = max(0, dot(normalize(world_normal), light));
    shaded = vec4(base_color * mix(direct, 1, ambient), 1);
}
"""
_INSTANCE = "4f 4f 4f 4f 3f/i"
_COLUMNS = ("column_0", "column_1", "column_2", "column_3", "color")


@dataclass(frozen=True)
class _Instances:
    """All parts of one kind of shape.

    Attributes:
        array: Vertex array that draws the parts.
        buffer: Transforms and colours of the parts, on the graphics card.
        rows: Transforms and colours of the parts, shape (parts, 19), float32.
        frames: Index of the frame that each part is attached to, shape (parts,).
        in_frame: Transforms of the parts in those frames, scale included, shape (parts, 4, 4).
    """

    array: Any
    buffer: Any
    rows: NDArray[np.float32]
    frames: NDArray[np.intp]
    in_frame: Floats


def _scale(part: Part) -> Sequence[float]:
    """Return the scale that turns a unit mesh into a part."""
    size = part.size
    if part.shape == "ball":
        return (size[0], size[0], size[0])
    if part.shape == "box":
        return (size[0] / 2, size[1] / 2, size[2] / 2)
    if part.shape == "mesh":
        return (1.0, 1.0, 1.0)
    return (size[0], size[0], size[1] / 2)


class OpenGLRenderer:
    """Renderer of the shapes of a robot's model and of scene objects.

    Raises:
        BackendError: OpenGL is not available without a window.
    """

    def __init__(self, model: UrdfModel) -> None:
        self._context = _context()
        self._robot = [
            (link.name, part)
            for link in model.bodies.values()
            for shape in link.visuals
            for part in _visible_parts(shape, model.path.parent)
        ]
        self.name = f"opengl ({self._context.info['GL_RENDERER']})"
        self._context.enable(moderngl.DEPTH_TEST)
        self._program = self._context.program(_VERTEX_SHADER, _FRAGMENT_SHADER)
        self._program["light"].value = light.DIRECTION
        self._program["ambient"].value = light.AMBIENT
        self._meshes = {
            kind: self._context.buffer(triangles.astype("f4").tobytes())
            for kind, triangles in (
                ("ball", mesh.ball()),
                ("box", mesh.box()),
                ("cylinder", mesh.cylinder()),
            )
        }
        #: Buffers by identity of the mesh, which is kept so that its identity is not reused.
        self._own: dict[int, tuple[Mesh, Any]] = {}
        self._canvases: dict[tuple[int, int], Any] = {}
        self._shown: Floats | None = None
        self._instances: list[_Instances] = []

    def _show(self, engine: Engine) -> None:
        """Upload robot and objects; frames of links come first, then those of objects."""
        parts = [(engine.rows[link], part) for link, part in self._robot]
        for frame, name in enumerate(engine.names(), len(engine.rows)):
            parts += [(frame, part) for part in engine.parts(name)]
        self._release(self._instances)
        self._instances = [
            self._upload(buffer, own)
            for kind, buffer in self._meshes.items()
            if (own := [(frame, part) for frame, part in parts if part.shape == kind])
        ]
        self._instances += [
            self._upload(self._own_mesh(part.mesh), [(frame, part)])
            for frame, part in parts
            if part.mesh is not None
        ]

    def _own_mesh(self, triangles: Mesh) -> Any:
        """Return the buffer of an object's mesh, which stays on the graphics card."""
        key = id(triangles)
        if key not in self._own:
            # Objects of all episodes share the mesh of a file, so that it is uploaded once.
            buffer = self._context.buffer(mesh.flat(triangles).astype("f4").tobytes())
            self._own[key] = triangles, buffer
        return self._own[key][1]

    def _upload(self, own: Any, parts: Sequence[tuple[int, Part]]) -> _Instances:
        rows = np.zeros((len(parts), 19), dtype=np.float32)
        rows[:, 16:] = [part.color for _, part in parts]
        buffer = self._context.buffer(rows.tobytes())
        layout = [(own, "3f 3f", "corner", "normal"), (buffer, _INSTANCE, *_COLUMNS)]
        return _Instances(
            self._context.vertex_array(self._program, layout),
            buffer,
            rows,
            np.array([frame for frame, _ in parts]),
            np.array([_in_frame(part) for _, part in parts]),
        )

    def render(self, engine: Engine, views: Sequence[View]) -> list[Image]:
        """Return images of robot and objects from each view; see ``Renderer.render``."""
        solids = engine.solids
        with self._context:
            if self._shown is not solids:
                self._show(engine)
                self._shown = solids
            self._update(_frames(engine.placements, solids))
            return [self._image(view) for view in views]

    def _image(self, view: View) -> Image:
        world_to_clip = view.eye_to_clip() @ view.world_to_eye()
        # OpenGL's first row is the lowest: the image is drawn upside down and so comes out right.
        world_to_clip[1] *= -1
        width, height = view.camera.width, view.camera.height
        canvas = self._canvas(width, height)
        canvas.use()
        canvas.clear(*BACKGROUND)
        self._program["world_to_clip"].write(world_to_clip.T.astype("f4").tobytes())
        for instances in self._instances:
            instances.array.render(instances=len(instances.rows))
        pixels = canvas.read(components=3, alignment=1)
        return np.frombuffer(pixels, dtype=np.uint8).reshape(height, width, 3)

    def _update(self, frames: Floats) -> None:
        for instances in self._instances:
            transforms = frames[instances.frames] @ instances.in_frame
            # OpenGL expects matrices by columns.
            instances.rows[:, :16] = transforms.transpose(0, 2, 1).reshape(-1, 16)
            instances.buffer.write(instances.rows.tobytes())

    def _canvas(self, width: int, height: int) -> Any:
        if (width, height) not in self._canvases:
            self._canvases[width, height] = self._context.framebuffer(
                self._context.renderbuffer((width, height), 3),
                self._context.depth_renderbuffer((width, height)),
            )
        return self._canvases[width, height]

    @staticmethod
    def _release(instances: Sequence[_Instances]) -> None:
        for each in instances:
            each.array.release()
            each.buffer.release()

    def close(self) -> None:
        """Free the context and everything in it."""
        self._context.release()


def _context() -> Any:
    # The types that moderngl states lack the backend's name and the uniforms' methods.
    create: Any = moderngl.create_context
    try:
        return create(standalone=True, backend="egl")
    except Exception as error:  # moderngl raises bare exceptions
        raise BackendError(str(error)) from error


def _visible_parts(shape: UrdfShape, folder: Path) -> Iterator[Part]:
    """Yield the parts of a visual of the robot's model; none for a mesh that cannot be read."""
    at, color = shape.origin, shape.color or _GREY
    if shape.kind == "mesh":
        file = find_mesh(shape.file, folder)
        triangles = None if file is None else read_simplified(file, shape.size)
        if triangles is not None:
            yield Part("mesh", (), at.xyz, at.quaternion, color, triangles)
        return
    kind = "cylinder" if shape.kind == "capsule" else shape.kind
    yield Part(kind, shape.size, at.xyz, at.quaternion, color)
    if shape.kind == "capsule":
        radius, height = shape.size
        along = rotations(np.array(at.quaternion))[:, 2] * height / 2
        for end in (np.array(at.xyz) + along, np.array(at.xyz) - along):
            yield Part("ball", (radius,), tuple(end.tolist()), at.quaternion, color)


def _in_frame(part: Part) -> Floats:
    """Return the transform of a part's unit mesh in its frame, with scale, shape (4, 4)."""
    transform = np.eye(4)
    transform[:3, :3] = rotations(np.array(part.quaternion)) * _scale(part)
    transform[:3, 3] = part.position
    return transform


def _frames(placements: Floats, solids: Floats) -> Floats:
    """Return the transforms of the frames of links, then objects, shape (frames, 4, 4)."""
    links = len(placements)
    frames = np.zeros((links + len(solids), 4, 4))
    frames[:links, :3, :3] = placements[:, :9].reshape(-1, 3, 3)
    frames[:links, :3, 3] = placements[:, 9:]
    frames[links:, :3, :3] = solids[:, ROTATION].reshape(-1, 3, 3)
    frames[links:, :3, 3] = solids[:, POSITION]
    frames[:, 3, 3] = 1
    return frames
