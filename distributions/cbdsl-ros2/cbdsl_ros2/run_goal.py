"""One episode for the action server of ROS 2: ``python -m cbdsl_ros2.run_goal``.

The first line of the standard input is the goal as JSON: ``program``, ``parameters``, ``seed``,
``backend``, ``cameras``, ``interface`` and ``released``. Each transition is a line of the output,
and the last line is the result, or ``error``. A further line of the input, or its end, interrupts
the episode and halts the robot; its text is the reason. So the robot halts with its server, too.
"""

from __future__ import annotations

import json
import sys
from contextlib import closing
from threading import Thread
from typing import TYPE_CHECKING, Any, TextIO

import cbdsl
from cbdsl.extend.backend import AttendedBackend
from cbdsl.extend.command import DiagnosticsError, UsageError, termination_interrupts

if TYPE_CHECKING:
    from cbdsl.api.open_robot import OpenRobot


class _Released:
    """Answer to the questions before a real robot moves.

    Args:
        released: True if the stage is set up and the robot may move.
    """

    def __init__(self, released: bool) -> None:
        self._released = released

    def confirm(self, text: str, question: str, *, released: bool) -> bool:
        """Return the consent in advance; see ``Person.confirm``.

        Raises:
            UsageError: There is none, or the question needs a person.
        """
        if not (self._released and released):
            way = "set the server's parameter 'released'" if released else "use cb run"
            raise UsageError(f"{question}? {way}")
        return True


def run_goal(goal: dict[str, Any], words: TextIO) -> dict[str, Any]:
    """Run an episode and return its result.

    Args:
        goal: Goal, see above.
        words: Lines that interrupt the episode.

    Raises:
        DiagnosticsError: A document has errors.
        UsageError: The goal cannot be run, or was interrupted.
    """
    request = cbdsl.load(goal["program"], values=_values(goal["parameters"]))
    cameras = goal["cameras"] or None
    with cbdsl.open_robot(request, backend=goal["backend"], cameras=cameras) as robot:
        if isinstance(robot.backend, AttendedBackend):
            robot.backend.attend(_Released(goal["released"]), goal["interface"])

        result = _run(robot, goal["seed"], words)
    return {
        "outcome": result.outcome,
        "reason": result.ending,
        "rewarded": result.rewarded,
        "duration": result.sim_seconds,
    }


def _run(robot: OpenRobot, seed: int, words: TextIO) -> cbdsl.EpisodeResult:
    """Run an episode until it ends, or a line or the end of ``words`` interrupts it."""
    reasons: list[str] = []

    def watch() -> None:
        reasons.append(words.readline().strip() or "its server has ended")

    Thread(target=watch, daemon=True).start()
    # Looked at between two ticks, so that no tick is left half done, and none is missed before the
    # first one.
    with closing(robot.ticks(seed, on_transition=_tell)) as episode:
        while not reasons:
            try:
                next(episode)
            except StopIteration as ended:
                result: cbdsl.EpisodeResult = ended.value
                return result
    raise UsageError(f"interrupted: {reasons[0]}")


def _values(parameters: list[str]) -> dict[str, str]:
    values = {}
    for each in parameters:
        name, sign, value = each.partition("=")
        if not (name and sign):
            raise UsageError(f"the parameter '{each}' is not of the form NAME=VALUE")
        values[name] = value
    return values


def _tell(transition: Any) -> None:
    _write({"step": transition.action, "state": transition.next_state, "time": transition.time})


def _write(row: dict[str, Any]) -> None:
    sys.stdout.write(json.dumps(row) + "\n")
    sys.stdout.flush()


def main() -> int:
    """Run the goal of the standard input."""
    goal = json.loads(sys.stdin.readline())
    try:
        with termination_interrupts():
            _write(run_goal(goal, sys.stdin))
    except DiagnosticsError as error:
        first = error.diagnostics[0]
        _write({"error": f"{first.place}: {first.code} {first.message}"})
        return 1
    except (UsageError, KeyboardInterrupt) as error:
        _write({"error": str(error) or "interrupted"})
        return 2
    return 0


if __name__ == "__main__":
    sys.exit(main())
