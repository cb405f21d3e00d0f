"""Attendance: the person at the terminal of a real robot."""

from __future__ import annotations

import contextlib
import sys
from itertools import islice
from typing import TYPE_CHECKING, Annotated

import typer

from cbdsl.cli.episodes.simulation import embodied
from cbdsl.diagnostics.errors import UsageError

if TYPE_CHECKING:
    from cbdsl.api.requests.run_request import RunRequest
    from cbdsl.backends.backend import Backend
    from cbdsl.kinematics.kinematics import Kinematics

Yes = Annotated[
    bool,
    typer.Option(
        "--yes",
        help="Real robot: confirm that the stage is set up and the robot may move, without "
        "questions.",
    ),
]
Interface = Annotated[
    str | None,
    typer.Option(
        "--interface",
        help="Real robot: network interface [loopback, invisible to other computers].",
    ),
]


# Ticks of a rehearsal: half a minute of the kinematic engine's time.
_TICKS = 600


class TerminalPerson:
    """Person who answers at the terminal.

    Args:
        yes: True if the person agreed in advance.
    """

    def __init__(self, *, yes: bool) -> None:
        self._yes = yes

    def confirm(self, text: str, question: str, *, released: bool) -> bool:
        """Print a situation, and return the answer; see ``Person.confirm``.

        Raises:
            UsageError: No terminal is there to ask at.
        """
        # `--yes` answers only questions that may be answered in advance. A release after a
        # disorderly stop, for example, needs a person.
        if self._yes and released:
            return True
        if not sys.stdin.isatty():
            way = "give --yes if the answer is yes" if released else "run it from a terminal"
            raise UsageError(f"{question}? There is no terminal to answer at; {way}")
        print(text, file=sys.stderr)
        return typer.confirm(question[0].upper() + question[1:], err=True)


def attend(
    backend: Backend,
    kinematics: Kinematics,
    request: RunRequest,
    *,
    yes: bool,
    interface: str | None,
) -> None:
    """Name the person at the terminal to a backend of a real robot, and rehearse the program.

    Args:
        backend: Backend, real or simulated.
        kinematics: Kinematics of the robot.
        request: Program to rehearse.
        yes: True if the person agreed in advance.
        interface: Network interface; loopback only if ``None``.

    Raises:
        UsageError: The backend is simulated, and --yes or --interface is given.
    """
    from cbdsl.backends.backend import AttendedBackend
    from cbdsl.robot.stopping_time import stopping_lines

    if isinstance(backend, AttendedBackend):
        backend.attend(TerminalPerson(yes=yes), interface)
        for line in stopping_lines(request.robot, kinematics.model, slow=True):
            print(f"warning: {line}", file=sys.stderr)
        rehearse(request)
    elif yes or interface is not None:
        option = "--yes" if yes else "--interface"
        raise UsageError(f"{option} is for a real robot, such as with --backend ros2")


def rehearse(request: RunRequest, seed: int = 0) -> None:
    """Run a program on the kinematic engine, which loads the compiled functions that it calls.

    Machine code that is loaded within a control tick would break the deadline of a real robot. A
    program that cannot run there is not rehearsed.

    Args:
        request: Program, robot and stage.
        seed: Seed of the episode.
    """
    import scipy.optimize  # noqa: F401 (causes of rest need it, which a rehearsal may lack)

    from cbdsl.numeric.compiled import load_kept
    from cbdsl.runtime.episode import Runner

    with contextlib.suppress(UsageError), embodied(request, "kinematic") as (backend, kinematics):
        runner = Runner(request.robot, kinematics, request.program, backend)
        for _ in islice(runner.ticks(request.stage, seed), _TICKS):
            pass
    # The rehearsal may have ended before the program's last states.
    load_kept()
