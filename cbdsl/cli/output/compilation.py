"""Progress of the compiler, so that a first run does not look like a hanging program."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from contextlib import contextmanager
from functools import cache
from types import FunctionType

from numba.core import event

from cbdsl.cli.output.progress import Progress
from cbdsl.numeric.compiled import uncompiled
from cbdsl.numeric.kernel_cache import problem

NOTICE = "compiling, once for each user and version; cb warm does this in advance"


@contextmanager
def told_of_compilation() -> Iterator[None]:
    """Report compilation on the standard error: a notice, then how many functions are left.

    Functions that an earlier process compiled are only loaded, which takes no time.
    """
    teller = _Teller()
    with event.install_listener("numba:compile", teller):
        yield
    teller.conclude()


class _Teller(event.Listener):
    """Listener that counts compiled functions; those of one kernel are nested in its event."""

    def __init__(self) -> None:
        self._pending: frozenset[FunctionType] = frozenset()
        self._compiled: set[FunctionType] = set()
        self._depth = 0
        self._progress: Progress | None = None

    def on_start(self, event: event.Event) -> None:
        """Print the notice before the first function."""
        if self._progress is None:
            _announce()
            self._progress = Progress("compiling functions")
            self._pending = uncompiled()
        self._depth += 1

    def on_end(self, event: event.Event) -> None:
        """Count a function, and clear the line where the program goes on."""
        self._compiled.add(event.data["dispatcher"].py_func)
        self._depth -= 1
        if self._progress is None:
            return
        # Functions may be compiled that were not expected. The union keeps the total at or above
        # the number of compiled ones.
        self._progress.note(len(self._compiled), len(self._pending | self._compiled))
        if self._depth == 0:
            self._progress.clear()

    def conclude(self) -> None:
        """Report machine code that could not be kept."""
        if self._progress is not None and (reason := problem()):
            _report(reason)


@cache
def _announce() -> None:
    """Print the notice once a process."""
    print(NOTICE, file=sys.stderr, flush=True)


@cache
def _report(reason: str) -> None:
    """Report once that machine code cannot be kept."""
    message = (
        f"compiled code cannot be kept ({reason}), so every run compiles again; "
        "NUMBA_CACHE_DIR names another folder"
    )
    print(message, file=sys.stderr, flush=True)
