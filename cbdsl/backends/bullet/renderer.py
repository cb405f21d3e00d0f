"""What makes the images, and which one is taken."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Literal, Protocol

from cbdsl.backends.backend import BackendError
from cbdsl.backends.bullet.opengl import OpenGLRenderer
from cbdsl.backends.bullet.tiny import TinyRenderer
from cbdsl.backends.bullet.view import View
from cbdsl.sensing.observation import Image


class Renderer(Protocol):
    """Makes images of the simulator's bodies.

    Attributes:
        name: what it is, for people.
    """

    name: str

    def show(self, bodies: Sequence[int]) -> None:
        """From now on show these bodies; to be called whenever one is added or removed."""
        ...

    def render(self, views: Sequence[View]) -> list[Image]:
        """The bodies as they are now, from each view.

        RGB, shape (height, width, 3), top row first.
        """
        ...

    def close(self) -> None:
        """Free what it holds."""
        ...


class NoRenderer:
    """For robots without cameras."""

    name = "none (no cameras)"

    def show(self, bodies: Sequence[int]) -> None:
        """Nobody looks."""

    def render(self, views: Sequence[View]) -> list[Image]:
        """No images, as there are no views."""
        return []

    def close(self) -> None:
        """Nothing is held."""


def make_renderer(
    client: int, kind: Literal["auto", "opengl", "tiny"], bodies: Sequence[int]
) -> Renderer:
    """The renderer of this kind; ``auto`` takes OpenGL where it works, else the simulator's own.

    Args:
        client: the simulator.
        kind: what the robot file asks for.
        bodies: what it has to show in any case; OpenGL knows no meshes.

    Raises:
        BackendError: ``opengl`` was asked for and there is no way to have it.
    """
    if kind == "tiny":
        return TinyRenderer(client)
    try:
        renderer = OpenGLRenderer(client)
        renderer.show(bodies)
    # moderngl raises bare exceptions, and whatever the reason, there are images without it.
    except Exception as error:
        if kind == "auto":
            return TinyRenderer(client)
        raise BackendError(
            f"OpenGL cannot make the images ({error}); on Debian and Ubuntu it needs the "
            "packages libegl1, libgl1 and libgl1-mesa-dri; "
            "the renderers 'auto' and 'tiny' do without"
        ) from error
    return renderer
