"""What every backend offers, and how one is found by its name."""

from __future__ import annotations

from collections.abc import Collection
from pathlib import Path
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from cbdsl.documents.robot import RobotDocument
from cbdsl.documents.stage import StageDocument
from cbdsl.errors.errors import UsageError
from cbdsl.sensing.observation import Observation
from cbdsl.types.registry import PluginError, Registry

Floats = NDArray[np.float64]


class BackendError(UsageError):
    """A backend cannot be found, or cannot embody a robot or a stage; the message says why."""


class Backend(Protocol):
    """A body in a world: it takes joint references and gives observations.

    Attributes:
        renderer: what makes the images, for people.
        control_period: simulated time of one step, s.
    """

    renderer: str
    control_period: float

    def reset(
        self,
        stage: StageDocument,
        context: str | None,
        rng: np.random.Generator,
        channels: Collection[str] | None = None,
    ) -> str:
        """Begin an episode; everything that chance decides in it is drawn from ``rng``.

        Args:
            stage: what is shown, and where.
            context: one of the stage's contexts; drawn by their shares when ``None``.
            rng: the only source of chance. Equal generators give equal episodes, whatever ran
                before.
            channels: of vision, whose regions the robot looks for; all of them when ``None``. A
                backend that reports regions may leave out the others.

        Returns:
            The name of the context.

        Raises:
            BackendError: the stage names something that it or the robot does not have.
        """
        ...

    def observe(self) -> Observation:
        """The sensors now. Asked again before the next step, it gives the same answer."""
        ...

    def apply(self, reference: Floats) -> None:
        """Set the references of the actuated joints, rad, shape (n,).

        The order is that of ``Joints.names``. They are reached at the end of the next step.
        """
        ...

    def step(self) -> None:
        """Let one control period pass."""
        ...

    def close(self) -> None:
        """Free what the backend holds; it cannot be used afterwards."""
        ...


class BackendFactory(Protocol):
    """What an entry point of the group ``cbdsl.backends`` refers to: a backend's class."""

    def __call__(self, robot: RobotDocument, urdf: Path, gui: bool = False) -> Backend:
        """Embody ``robot``, whose model is the file ``urdf``; ``gui`` opens a window if it can."""
        ...


_METHODS = ("reset", "observe", "apply", "step", "close")


def _factory(_: str, factory: Any) -> BackendFactory:
    """Backend class with all methods of ``Backend``."""
    lacking = [method for method in _METHODS if not callable(getattr(factory, method, None))]
    if lacking:
        raise PluginError(f"lacks the methods {', '.join(lacking)}")
    checked: BackendFactory = factory
    return checked


BACKENDS: Registry[BackendFactory] = Registry(
    "backend",
    "cbdsl.backends",
    {
        "bullet": "cbdsl.backends.bullet.backend:BulletBackend",
        "kinematic": "cbdsl.backends.kinematic.backend:KinematicBackend",
    },
    _factory,
)


def find_backend(name: str) -> BackendFactory:
    """Backend class of a name.

    Raises:
        BackendError: there is none of this name, what it needs is not installed, or it is no
            backend.
    """
    try:
        return BACKENDS.get(name)
    except ImportError as error:
        raise BackendError(
            f"backend '{name}' cannot be loaded: {error}; try: pip install 'cbdsl[sim]'"
        ) from error
    except UsageError as error:
        raise BackendError(str(error)) from error
