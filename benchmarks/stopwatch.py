"""Clocks around methods, put there for a benchmark and taken away afterwards."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Mapping, Sequence
from time import perf_counter
from typing import Any, Self

Method = tuple[type, str]

Stages = Mapping[str, Sequence[Method]]
"""Classes and names of methods, by stage."""


class Stopwatch:
    """Time spent in the methods of each stage, without the stages that they call.

    The clocks themselves cost a fraction of a microsecond a call.

    Args:
        stages: Classes and names of methods, by stage.
        clock: Function that returns the time, s.

    Attributes:
        seconds: Time by stage; clear it to restart.
    """

    def __init__(self, stages: Stages, clock: Callable[[], float] = perf_counter) -> None:
        self._stages, self._clock = stages, clock
        self._originals: list[tuple[Method, Callable[..., Any]]] = []
        self._inner = 0.0
        self.seconds: dict[str, float] = defaultdict(float)

    def __enter__(self) -> Self:
        for stage, methods in self._stages.items():
            for owner, name in methods:
                original = vars(owner)[name]
                self._originals.append(((owner, name), original))
                setattr(owner, name, self._timed(original, stage))
        return self

    def __exit__(self, *error: object) -> None:
        for (owner, name), original in self._originals:
            setattr(owner, name, original)
        self._originals.clear()

    def _timed(self, method: Callable[..., Any], stage: str) -> Callable[..., Any]:
        def timed(*args: Any, **kwargs: Any) -> Any:
            # ``_inner`` adds up the clocked calls inside the present one. A stage counts its
            # elapsed time without them, and its caller counts the whole call as inner time. Times
            # of stages therefore add up, even if one method calls another.
            outer, self._inner = self._inner, 0.0
            start = self._clock()
            try:
                return method(*args, **kwargs)
            finally:
                elapsed = self._clock() - start
                self.seconds[stage] += elapsed - self._inner
                self._inner = outer + elapsed

        return timed
