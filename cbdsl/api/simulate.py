"""``cbdsl.simulate``: a robot in a simulated stage, beside the truth of its world."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from cbdsl.api.open_robot import OpenRobot
    from cbdsl.api.requests.run_request import RunRequest
    from cbdsl.api.simulation.truth import Truth


@dataclass(frozen=True)
class SimulatedRobot:
    """Robot in a simulated world.

    Attributes:
        robot: Robot, which acts on its observations alone.
        truth: State of the world that only its engine knows, for judges and tests.
    """

    robot: OpenRobot
    truth: Truth


@contextmanager
def simulate(
    program: str | Path | RunRequest,
    *,
    backend: str | None = None,
    cameras: str | None = None,
    persistent: bool = False,
) -> Iterator[SimulatedRobot]:
    """Open the robot of a program in a simulated world whose truth can be read.

    Args:
        program: Result of ``load``, or a file or name for it.
        backend: Name of a simulated backend; the first installed one if ``None``.
        cameras: ``rendered`` or ``ideal``; the backend's own choice if ``None``.
        persistent: True to keep the world between episodes, regardless of the stage.

    Raises:
        DiagnosticsError: A document has errors.
        UsageError: An item is missing, not installed or unsuitable, or the backend is no
            simulation.
    """
    from cbdsl.api.open_robot import open_robot
    from cbdsl.api.simulation.truth import Truth
    from cbdsl.backends.simulated_backend import SimulatedBackend
    from cbdsl.diagnostics.errors import UsageError

    opened = open_robot(program, backend=backend, cameras=cameras, persistent=persistent)
    with opened as robot:
        # A real robot, such as with `ros2`, has no engine that knows the truth.
        if not isinstance(robot.backend, SimulatedBackend):
            raise UsageError(
                f"backend '{backend}' simulates no world whose truth can be read; "
                "bullet, mujoco and kinematic do"
            )
        yield SimulatedRobot(robot, Truth(robot.backend.truth))
