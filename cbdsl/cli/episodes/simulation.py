"""Backend on which a command runs programs."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from itertools import islice
from typing import TYPE_CHECKING

from cbdsl.backends.engines import extra_advice
from cbdsl.diagnostics.errors import UsageError
from cbdsl.robot.urdf import UrdfError

if TYPE_CHECKING:
    from cbdsl.api.requests.run_request import RunRequest
    from cbdsl.backends.backend import Backend
    from cbdsl.kinematics.kinematics import Kinematics

# Program that moves joints without images, and its ticks.
_PROGRAM, _TICKS = "posture", 2
_COMMAND = """
from cbdsl.numeric.numba_settings import ignore_settings_of_folder
ignore_settings_of_folder()
from cbdsl.cli.episodes.simulation import compile_ticks
compile_ticks({})
"""


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
    clearance = request.program.all_guards.clearance
    clearances = [None if clearance is None else f"{clearance} m"]
    with (
        told_of_compilation(),
        ticks_compiled_meanwhile(clearances),
        embodied(request, backend, gui=gui, cameras=cameras) as opened,
    ):
        yield opened


@contextmanager
def embodied(
    request: RunRequest, backend: str, *, gui: bool = False, cameras: str | None = None
) -> Iterator[tuple[Backend, Kinematics]]:
    """Yield the same as ``simulation``, without compilation in another process.

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


@contextmanager
def ticks_compiled_meanwhile(clearances: Sequence[str | None]) -> Iterator[None]:
    """Let another process compile the tick of control meanwhile, if it is not kept.

    The tick takes more than half of the time of a first run. A process that needs a function
    waits for the other one that compiles it.

    Args:
        clearances: Clearances of the robot's links with which it is compiled, ``None`` for none.
    """
    from cbdsl.control.compiled_tick import tick
    from cbdsl.numeric.compiled import is_kept

    if len(os.sched_getaffinity(0)) < 2 or is_kept(tick):
        yield
        return
    # Modules in the current folder, of another author, are not imported.
    words = [sys.executable, "-P", "-c", _COMMAND.format(tuple(clearances))]
    none = subprocess.DEVNULL
    with subprocess.Popen(words, stdin=none, stdout=none, stderr=none) as other:
        try:
            yield
        finally:
            other.kill()


def compile_ticks(clearances: Sequence[str | None]) -> None:
    """Compile the tick of control, and all that a robot without images needs for it."""
    from cbdsl.api.requests.load_request import LoadOptions
    from cbdsl.documents.context import Context
    from cbdsl.documents.stage import empty_stage
    from cbdsl.runtime.episode import Runner

    for clearance in clearances:
        request = LoadOptions(clearance=clearance).read(_PROGRAM)
        dark = {"contexts": {"dark": Context(dark_after=0.0)}}
        stage = empty_stage(request.robot.name).model_copy(update=dark)
        with embodied(request, "kinematic") as (backend, kinematics):
            runner = Runner(request.robot, kinematics, request.program, backend)
            for _ in islice(runner.ticks(stage, seed=0), _TICKS):
                continue
