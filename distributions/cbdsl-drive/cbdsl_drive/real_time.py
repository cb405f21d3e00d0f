"""Real time: conditions under which a process keeps its deadlines while a robot moves."""

from __future__ import annotations

import contextlib
import gc
import os
import sys
from pathlib import Path

# Thresholds of Python's own collections of garbage; the command line raises them.
_THRESHOLDS = 700, 10, 10
_PRIORITY = 10


class RealTime:
    """Conditions of real time, from ``begin`` to ``end``.

    Garbage: a full collection visits all objects of the process, which takes 60 ms after all
    modules and machine code are loaded. ``begin`` excludes present objects from collections, so
    that later ones are short.

    Priority: where the operating system permits, all present threads precede other processes
    (``SCHED_FIFO`` of Linux). Threads and processes that start later do not.
    """

    def __init__(self) -> None:
        self._thresholds: tuple[int, int, int] | None = None
        self._raised: list[int] = []

    def begin(self) -> None:
        """Enter real time, which takes some 100 ms; may be called again for a new episode."""
        self.end()
        self._thresholds = gc.get_threshold()
        gc.collect()
        gc.freeze()
        gc.set_threshold(*_THRESHOLDS)
        if sys.platform == "linux":
            self._raise_threads()

    def end(self) -> None:
        """Leave real time, if it was entered."""
        if self._thresholds is None:
            return
        for thread in self._raised:
            with contextlib.suppress(ProcessLookupError):
                os.sched_setscheduler(thread, os.SCHED_OTHER, os.sched_param(0))
        self._raised.clear()
        gc.set_threshold(*self._thresholds)
        gc.unfreeze()
        self._thresholds = None

    def _raise_threads(self) -> None:
        """Let all threads of ordinary priority precede other processes."""
        # Threads and processes that start later would inherit the priority without the second flag.
        policy, priority = os.SCHED_FIFO | os.SCHED_RESET_ON_FORK, os.sched_param(_PRIORITY)
        for thread in (int(path.name) for path in Path("/proc/self/task").iterdir()):
            # The thread may have ended, and most users may not raise a priority.
            with contextlib.suppress(ProcessLookupError, PermissionError):
                if os.sched_getscheduler(thread) == os.SCHED_OTHER:
                    os.sched_setscheduler(thread, policy, priority)
                    self._raised.append(thread)
