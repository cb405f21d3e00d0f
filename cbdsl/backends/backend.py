"""The backend contract, and the look-up of a backend by its name."""

from __future__ import annotations

from collections.abc import Collection, Iterator
from contextlib import contextmanager
from inspect import signature
from pathlib import Path
from typing import Any, Protocol, runtime_checkable

import numpy as np

from cbdsl.backends.distributions import require_unmixed
from cbdsl.backends.engines import remedy
from cbdsl.backends.quiet import quiet_stderr
from cbdsl.diagnostics.errors import UsageError
from cbdsl.documents.robot import RobotDocument
from cbdsl.documents.stage import StageDocument
from cbdsl.numeric.arrays import Floats
from cbdsl.robot.urdf import UrdfError
from cbdsl.sensing.observation import Observation
from cbdsl.types.registry import PluginError, Registry

#: Kinds of cameras that a run may choose.
CAMERAS = ("rendered", "ideal")


class BackendError(UsageError):
    """Failure to find a backend, or to embody a robot or a stage; the message states the cause."""


class Backend(Protocol):
    """Robot in a world: takes joint references and returns observations.

    It keeps the velocity and effort limits of the robot's URDF for any reference.

    Attributes:
        renderer: Source of the images, for people.
        control_period: Simulated time of one step, s.
        deadline: Wall time that the robot's controllers may take in a tick, from an observation
            until its reference, s; ``None`` if the world waits for them. If they take longer, the
            episode ends and the backend is halted.
    """

    renderer: str
    control_period: float
    deadline: float | None

    def reset(
        self,
        stage: StageDocument,
        context: str | None,
        rng: np.random.Generator,
        channels: Collection[str] | None = None,
    ) -> str:
        """Begin an episode; ``rng`` draws everything that is left to chance.

        Args:
            stage: Stage with the objects and their places.
            context: Context of the stage; drawn by the contexts' shares if ``None``.
            rng: Only source of chance; equal generators give equal episodes, independent of earlier
                runs.
            channels: Channels of vision whose regions the robot looks for; all if ``None``. A
                backend that reports regions may leave out the others.

        Returns:
            The name of the context.

        Raises:
            BackendError: The stage names something that it or the robot does not have.
        """
        ...

    def observe(self) -> Observation:
        """Return the sensors' values; further calls before the next step return the same values."""
        ...

    def apply(self, reference: Floats) -> None:
        """Set the references of the actuated joints, rad, shape (n,).

        The order is that of ``Joints.names``. They are reached at the end of the next step.
        """
        ...

    def step(self) -> None:
        """Let one control period pass."""
        ...

    def halt(self) -> None:
        """Freeze the references at the measured positions: the robot is no longer controlled.

        Called when an episode cannot begin or continue, and at Ctrl-C, also during ``reset`` and
        before the first one. ``reset`` or ``close`` follows. It works in each of these states.
        """
        ...

    def close(self) -> None:
        """Free the backend's resources; it cannot be used afterwards."""
        ...


@runtime_checkable
class ResumableBackend(Protocol):
    """Backend whose world can persist from one episode to the next."""

    def resume(
        self,
        stage: StageDocument,
        context: str | None,
        channels: Collection[str] | None = None,
        *,
        undisturbed: bool = False,
    ) -> str | None:
        """Begin an episode in the world that the last episode left, robot and references included.

        The experimenter puts things back as the stage says. Time begins at 0 again, and the first
        observation has images; all random draws continue the streams of the reset.

        Args:
            stage: Stage of the world.
            context: Context of the world; any if ``None``.
            channels: Channels of vision, as in ``Backend.reset``.
            undisturbed: True if the experimenter does nothing before the episode.

        Returns:
            The name of the context; ``None`` where the world is of another stage or context, or
            none has begun, so that it has to be reset.
        """
        ...


@runtime_checkable
class StagingBackend(Protocol):
    """Backend that sets up a stage around its robot, which keeps its posture."""

    def set_up_around(
        self, stage: StageDocument, context: str | None, rng: np.random.Generator
    ) -> str:
        """Begin an episode as ``Backend.reset`` does, but without a jump of a joint.

        The robot has to stand.

        Args:
            stage: Stage with the objects and their places.
            context: Context of the stage; drawn by the contexts' shares if ``None``.
            rng: Only source of chance.

        Returns:
            The name of the context.
        """
        ...


class Person(Protocol):
    """Person beside a real robot, or at the terminal of its computer."""

    def confirm(self, text: str, question: str, *, released: bool) -> bool:
        """Return the answer to a question.

        Args:
            text: Situation, in lines.
            question: Question that yes or no answers.
            released: True if a consent in advance, ``--yes``, may answer it.
        """
        ...


@runtime_checkable
class AttendedBackend(Protocol):
    """Backend of a real robot: a person sets up its stage and releases it."""

    def attend(self, person: Person, interface: str | None = None) -> None:
        """Set the person who confirms, and the network interface.

        Args:
            person: Person who answers.
            interface: Network interface; loopback only if ``None``.
        """
        ...


class BackendFactory(Protocol):
    """Target of an entry point of the group ``cbdsl.backends``: a backend's class."""

    def __call__(
        self, robot: RobotDocument, urdf: Path, *, gui: bool = False, cameras: str | None = None
    ) -> Backend:
        """Embody a robot.

        Args:
            robot: Robot document.
            urdf: URDF of the robot.
            gui: True to open a window.
            cameras: One of ``CAMERAS``; the backend's own choice if ``None``.

        Raises:
            BackendError: Robot, window or cameras are not available.
        """
        ...


_METHODS = ("reset", "observe", "apply", "step", "halt", "close")


def _factory(_: str, factory: Any) -> BackendFactory:
    """Return a backend class that has all methods of ``Backend``."""
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
    providers={"mujoco": "cbdsl[mujoco]", "ros2": "cbdsl[ros2]"},
)


def name_of(backend: Backend) -> str:
    """Return the name of a backend in messages: its own, or that of its class."""
    return BACKENDS.name_of(type(backend)) or type(backend).__name__


def find_backend(name: str) -> BackendFactory:
    """Return the backend class of a name.

    Raises:
        BackendError: No backend has this name, a required package is missing or mixed with another
            version, or the target is not a backend.
    """
    try:
        require_unmixed("pybullet" if name == "bullet" else name)
        with quiet_stderr():  # engines say when they were built, in each process that has one
            return BACKENDS.get(name)
    except ImportError as error:
        raise BackendError(f"backend '{name}' cannot be loaded: {error}; {remedy(name)}") from error
    except UsageError as error:
        raise BackendError(str(error)) from error


def embody(
    name: str, robot: RobotDocument, urdf: Path, *, gui: bool = False, cameras: str | None = None
) -> Backend:
    """Return a robot on the backend of a name; see ``BackendFactory``.

    Raises:
        BackendError: There is no such backend, or it cannot embody the robot with these cameras.
    """
    factory = find_backend(name)
    if cameras is None:
        with _embodiment_named(name):
            return factory(robot, urdf, gui=gui)
    if cameras not in CAMERAS:
        raise BackendError.unknown("kind of cameras", cameras, CAMERAS)
    # A backend of another package may have no choice of cameras, and no such argument.
    if "cameras" not in signature(factory).parameters:
        raise BackendError(f"backend '{name}' offers no choice of cameras; leave --cameras out")
    with _embodiment_named(name):
        return factory(robot, urdf, gui=gui, cameras=cameras)


@contextmanager
def _embodiment_named(name: str) -> Iterator[None]:
    """Raise the backend's own exceptions with its name; unreadable models name themselves."""
    try:
        yield
    # These messages name their cause already.
    except (UsageError, UrdfError, ImportError):
        raise
    except Exception as error:
        raise BackendError(
            f"backend '{name}' cannot embody the robot: {type(error).__name__}: {error}"
        ) from error
