"""Renderers, and the choice of one."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Literal, Protocol

from cbdsl.backends.backend import BackendError
from cbdsl.backends.cameras.view import View
from cbdsl.backends.staging.engine import Engine
from cbdsl.robot.urdf import UrdfModel
from cbdsl.sensing.observation import Image


class Renderer(Protocol):
    """Makes images of an engine's robot and objects.

    Attributes:
        name: for people.
    """

    name: str

    def render(self, engine: Engine, views: Sequence[View]) -> list[Image]:
        """Robot and objects as they are now, from each view.

        RGB, shape (height, width, 3), top row first.
        """
        ...

    def close(self) -> None:
        """Free what it holds."""
        ...


class NoRenderer:
    """Renderer for robots without cameras."""

    name = "none (no cameras)"

    def render(self, engine: Engine, views: Sequence[View]) -> list[Image]:
        """No images, as there are no views."""
        return []

    def close(self) -> None:
        """Nothing is held."""


def make_renderer(
    kind: Literal["auto", "opengl", "tiny"],
    model: UrdfModel,
    tiny: Callable[[], Renderer] | None,
) -> Renderer:
    """The renderer of this kind; ``auto`` takes OpenGL where it works, else the engine's own.

    Args:
        kind: what the robot file asks for.
        model: of the robot; OpenGL shows no meshes.
        tiny: makes the engine's own renderer, if it has one.

    Raises:
        BackendError: the one that was asked for cannot be had.
    """
    if kind == "tiny":
        if tiny is None:
            raise BackendError(
                "only the bullet backend has the renderer 'tiny' that the robot file asks for; "
                "allowed are the renderers 'auto' and 'opengl', or ideal cameras"
            )
        return tiny()
    try:
        # Ideal cameras need no graphics, and take no time to load them.
        from cbdsl.backends.cameras.opengl import OpenGLRenderer

        return OpenGLRenderer(model)
    # moderngl raises bare exceptions, and whatever the reason, there are images without it.
    except Exception as error:
        if kind == "auto" and tiny is not None:
            return tiny()
        without = "ideal cameras do" if tiny is None else "the renderers 'auto' and 'tiny' do"
        raise BackendError(
            f"OpenGL cannot make the images ({error}); on Debian and Ubuntu it needs the "
            f"packages libegl1, libgl1 and libgl1-mesa-dri; {without} without"
        ) from error
