"""Images by OpenGL without a window: every body as instances of three unit meshes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import moderngl
import numpy as np
import pybullet as p
from numpy.typing import NDArray

from cbdsl.backends.bullet import light, mesh
from cbdsl.backends.bullet.view import View
from cbdsl.backends.staging.pose import rotations
from cbdsl.sensing.observation import Image

Floats = NDArray[np.float64]

BACKGROUND = (0.78, 0.78, 0.78)

# Light and shade multiply a colour, so that its hue and saturation stay.
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
    """All bodies' parts of one kind of shape.

    Attributes:
        array: draws them.
        buffer: their transforms and colours, on the graphics card.
        rows: the same, shape (parts, 19), float32.
        frames: index of the frame that each is attached to, shape (parts,).
        in_frame: their transforms in those frames, scale included, shape (parts, 4, 4).
    """

    array: Any
    buffer: Any
    rows: NDArray[np.float32]
    frames: NDArray[np.intp]
    in_frame: Floats


def _scale(kind: int, size: Sequence[float]) -> Sequence[float]:
    """Of a unit mesh, from the size that the simulator reports of a visual shape."""
    if kind == p.GEOM_SPHERE:
        return (size[0], size[0], size[0])
    if kind == p.GEOM_BOX:
        return (size[0] / 2, size[1] / 2, size[2] / 2)
    return (size[1], size[1], size[0] / 2)


class OpenGLRenderer:
    """Renders what the simulator knows of its bodies' visual shapes.

    Raises:
        Exception: there is no OpenGL to be had without a window.
    """

    def __init__(self, client: int) -> None:
        self._client = client
        # The types that moderngl states lack the backend's name and the uniforms' methods.
        create: Any = moderngl.create_context
        self._context = create(standalone=True, backend="egl")
        self.name = f"opengl ({self._context.info['GL_RENDERER']})"
        self._context.enable(moderngl.DEPTH_TEST)
        self._program = self._context.program(_VERTEX_SHADER, _FRAGMENT_SHADER)
        self._program["light"].value = light.DIRECTION
        self._program["ambient"].value = light.AMBIENT
        self._meshes = {
            kind: self._context.buffer(triangles.astype("f4").tobytes())
            for kind, triangles in (
                (p.GEOM_SPHERE, mesh.ball()),
                (p.GEOM_BOX, mesh.box()),
                (p.GEOM_CYLINDER, mesh.cylinder()),
            )
        }
        self._canvases: dict[tuple[int, int], Any] = {}
        self._bodies: list[tuple[int, list[int]]] = []
        self._instances: list[_Instances] = []

    def show(self, bodies: Sequence[int]) -> None:
        """From now on show these bodies; to be called whenever one is added or removed.

        Raises:
            ValueError: one has a shape that cannot be drawn.
        """
        frames: dict[tuple[int, int], int] = {}
        parts: dict[int, list[tuple[int, Floats, Sequence[float]]]] = {k: [] for k in self._meshes}
        self._bodies = []
        for body in bodies:
            links = list(range(p.getNumJoints(body, physicsClientId=self._client)))
            self._bodies.append((body, links))
            frames |= {(body, link): len(frames) + link + 1 for link in (-1, *links)}
            for shape in p.getVisualShapeData(body, physicsClientId=self._client):
                if shape[2] not in parts:
                    raise ValueError("only balls, boxes and cylinders can be drawn")
                frame = frames[body, shape[1]]
                parts[shape[2]].append((frame, self._part(shape), shape[7][:3]))
        with self._context:
            self._release(self._instances)
            self._instances = [
                self._upload(kind, of_kind) for kind, of_kind in parts.items() if of_kind
            ]

    @staticmethod
    def _part(shape: tuple[Any, ...]) -> Floats:
        transform = np.eye(4)
        transform[:3, :3] = rotations(np.array(shape[6])) * _scale(shape[2], shape[3])
        transform[:3, 3] = shape[5]
        return transform

    def _upload(
        self, kind: int, parts: Sequence[tuple[int, Floats, Sequence[float]]]
    ) -> _Instances:
        rows = np.zeros((len(parts), 19), dtype=np.float32)
        rows[:, 16:] = [color for _, _, color in parts]
        buffer = self._context.buffer(rows.tobytes())
        layout = [
            (self._meshes[kind], "3f 3f", "corner", "normal"),
            (buffer, _INSTANCE, *_COLUMNS),
        ]
        return _Instances(
            self._context.vertex_array(self._program, layout),
            buffer,
            rows,
            np.array([frame for frame, _, _ in parts]),
            np.array([in_frame for _, in_frame, _ in parts]),
        )

    def render(self, views: Sequence[View]) -> list[Image]:
        """The bodies as they are now, from each view; see ``Renderer.render``."""
        with self._context:
            self._update()
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

    def _update(self) -> None:
        frames = self._frames()
        for instances in self._instances:
            transforms = frames[instances.frames] @ instances.in_frame
            instances.rows[:, :16] = transforms.transpose(0, 2, 1).reshape(-1, 16)
            instances.buffer.write(instances.rows.tobytes())

    def _frames(self) -> Floats:
        """Transforms of all bodies' and links' frames, shape (frames, 4, 4)."""
        positions, quaternions = [], []
        for body, links in self._bodies:
            position, quaternion = p.getBasePositionAndOrientation(
                body, physicsClientId=self._client
            )
            if links:  # only the robot has links, and its base is the world
                position, quaternion = (0.0, 0.0, 0.0), (0.0, 0.0, 0.0, 1.0)
            positions.append(position)
            quaternions.append(quaternion)
            states = p.getLinkStates(
                body, links, computeForwardKinematics=1, physicsClientId=self._client
            )
            positions += [state[4] for state in states or ()]
            quaternions += [state[5] for state in states or ()]
        frames = np.zeros((len(positions), 4, 4))
        frames[:, :3, :3] = rotations(np.array(quaternions))
        frames[:, :3, 3] = positions
        frames[:, 3, 3] = 1
        return frames

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
