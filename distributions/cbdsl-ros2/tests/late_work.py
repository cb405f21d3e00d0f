"""Late work: modules imported and machine code loaded while a robot moves.

``python distributions/cbdsl-ros2/tests/late_work.py FILE WORDS`` runs the command line with words,
such as ``run reach --backend ros2``, and writes the names of late modules and functions to a file.
"""

from __future__ import annotations

import functools
import sys
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

from numba.core import event

from cbdsl_drive.backend import DrivenBackend
from cbdsl_drive.safety_supervisor import State
from cbdsl_ros2.topic_server import Moment, RobotServer


class LateWork(event.Listener):
    """Recorder of imports and of machine code, from the first reference to the last.

    Attributes:
        events: Names of modules and functions.
    """

    def __init__(self) -> None:
        self.events: list[str] = []
        self._moves: Callable[[], bool] = lambda: False

    def find_spec(self, name: str, *_: object) -> None:
        """Note an import as a finder of ``sys.meta_path``, and leave it to others."""
        if self._moves():
            self.events.append(name)

    def on_start(self, event: event.Event) -> None:
        """Note a function whose machine code is compiled or loaded."""
        if self._moves():
            self.events.append(f"machine code {event.data}")

    def on_end(self, event: event.Event) -> None:
        """Ignore the end."""

    def record(self) -> None:
        """Record both sides of driven robots from now on."""
        recorder, begin, serve = self, DrivenBackend.__init__, RobotServer.serve

        @functools.wraps(begin)
        def begin_driving(self: DrivenBackend, *words: Any, **options: Any) -> None:
            begin(self, *words, **options)
            recorder._moves = lambda: self.supervisor.state is State.RUNNING

        def begin_serving(self: RobotServer, watch: Callable[[Moment], bool]) -> None:
            recorder._moves = lambda: True
            try:
                serve(self, watch)
            finally:
                recorder._moves = lambda: False

        set_up = RobotServer._set_up_next

        @functools.wraps(set_up)
        def set_up_at_rest(self: RobotServer, setup: Any) -> None:
            # The program sends no references until the stage is set up.
            moves, recorder._moves = recorder._moves, lambda: False
            try:
                set_up(self, setup)
            finally:
                recorder._moves = moves

        RobotServer._set_up_next = set_up_at_rest  # type: ignore[method-assign]
        DrivenBackend.__init__ = begin_driving  # type: ignore[method-assign]
        RobotServer.serve = begin_serving  # type: ignore[method-assign]
        sys.meta_path.insert(0, self)  # type: ignore[arg-type]
        event.register("numba:compiler_lock", self)


def main(words: Sequence[str]) -> None:
    """Run the command line, and write late work into a file."""
    from cbdsl.cli import main as command

    file, sys.argv = Path(words[0]), ["cb", *words[1:]]
    late = LateWork()
    try:
        late.record()
        command.main()
    finally:
        file.write_text("".join(f"{name}\n" for name in late.events))


if __name__ == "__main__":
    main(sys.argv[1:])
