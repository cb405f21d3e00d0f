"""Backend on which a command runs programs."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING

from cbdsl.backends.engines import extra_advice
from cbdsl.diagnostics.errors import UsageError
from cbdsl.robot.urdf import UrdfError

if TYPE_CHECKING:
    from cbdsl.api.requests.run_request import RunRequest
    from cbdsl.backends.backend import Backend
    from cbdsl.kinematics.kinematics import Kinematics


@contextmanager
def needing_simulation() -> Iterator[None]:
    """Report a missing package by the name of the extra that installs it.

    Raises:
        UsageError: An imported package, or a system library of it, is not installed.
    """
    try:
        yield
    except ModuleNotFoundError as error:
        extra = "ros2" if (error.name or "").split(".")[0] == "cyclonedds" else "sim"
        raise UsageError(
            f"running needs {error.name}, which is not installed: {extra_advice(extra)}"
        ) from error
    except ImportError as error:
        # A package is installed, but it lacks a system library, such as libgomp.
        raise UsageError(
            f"running needs more than is installed: {error}; docs/how_to/install.md lists the "
            "packages of Debian, such as libgomp1"
        ) from error


@contextmanager
def simulation(
    request: RunRequest, backend: str, *, gui: bool = False, cameras: str | None = None
) -> Iterator[tuple[Backend, Kinematics]]:
    """Yield the backend with the robot of a request, and the robot's kinematics.

    Raises:
        UsageError: The backend or its cameras are unknown, a package is not installed, or the
            backend cannot read the robot's model.
    """
    with needing_simulation():
        from cbdsl.backends.backend import find_backend
        from cbdsl.cli.output.compilation import told_of_compilation

        find_backend(backend)
    with told_of_compilation(), embodied(request, backend, gui=gui, cameras=cameras) as opened:
        yield opened


@contextmanager
def embodied(
    request: RunRequest, backend: str, *, gui: bool = False, cameras: str | None = None
) -> Iterator[tuple[Backend, Kinematics]]:
    """Yield the same as ``simulation``, without reports of compilation.

    Raises:
        UsageError: As for ``simulation``.
    """
    with needing_simulation():
        from cbdsl.backends.backend import embody
        from cbdsl.backends.backend_calls import closing_backend
        from cbdsl.kinematics.kinematics import Kinematics
    try:
        with needing_simulation():
            simulated = embody(backend, request.robot, request.urdf, gui=gui, cameras=cameras)
        with closing_backend(simulated):
            yield simulated, Kinematics(request.robot, request.urdf)
    except UrdfError as error:
        raise UsageError(str(error)) from error
