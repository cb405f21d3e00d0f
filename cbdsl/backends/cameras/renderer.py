"""Renderers, and the choice of one."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Literal, Protocol

from cbdsl.backends.backend import BackendError
from cbdsl.backends.cameras.view import View
from cbdsl.backends.staging.engine import Engine
from cbdsl.numeric.arrays import Image
from cbdsl.robot.urdf import UrdfModel


class Renderer(Protocol):
    """Renderer of an engine's robot and objects.

    Attributes:
        name: Name of the renderer, for people.
    """

    name: str

    def render(self, engine: Engine, views: Sequence[View]) -> list[Image]:
        """Return images of robot and objects from each view.

        Each is RGB, shape (height, width, 3), top row first.
        """
        ...

    def close(self) -> None:
        """Free the renderer's resources."""
        ...


class NoRenderer:
    """Renderer for robots without cameras."""

    name = "none (no cameras)"

    def render(self, engine: Engine, views: Sequence[View]) -> list[Image]:
        """Return no images, as there are no views."""
        return []

    def close(self) -> None:
        """Do nothing: there are no resources to free."""


# Backends that have a renderer of their own, by the renderer's name.
_OWNERS = {"tiny": "bullet", "mujoco": "mujoco"}


def make_renderer(
    kind: Literal["auto", "opengl", "tiny", "mujoco"],
    model: UrdfModel,
    own: Mapping[str, Callable[[], Renderer]],
) -> Renderer:
    """Return the renderer of a kind; ``auto`` is OpenGL if it works, else a software renderer.

    Args:
        kind: Renderer that the robot file requests.
        model: URDF model of the robot.
        own: Factories of the engine's own renderers, if it has any.

    Raises:
        BackendError: The requested renderer is not available.
    """
    if kind in own:
        return own[kind]()
    # For example 'tiny', PyBullet's renderer, with the engine MuJoCo.
    if kind in _OWNERS:
        allowed = ", ".join(f"'{name}'" for name in ("auto", *own))
        raise BackendError(
            f"only the {_OWNERS[kind]} backend has the renderer '{kind}' that the robot file asks "
            f"for; allowed are the renderers {allowed} and 'opengl', or ideal cameras"
        )
    try:
        return _opengl(model)
    except BackendError as error:
        software = own.get("tiny")
        if kind == "auto" and software is not None:
            return software()
        without = "the renderers 'auto' and 'tiny' do" if software else "ideal cameras do"
        raise BackendError(
            f"OpenGL is missing ({error}); on Debian and Ubuntu it needs the "
            f"packages libegl1, libgl1 and libgl1-mesa-dri; {without} without"
        ) from error


def _opengl(model: UrdfModel) -> Renderer:
    # Ideal cameras need no graphics, so they need not wait for this import.
    try:
        from cbdsl.backends.cameras.opengl import OpenGLRenderer
    except ImportError as error:
        raise BackendError(str(error)) from error
    return OpenGLRenderer(model)
