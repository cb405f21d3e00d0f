"""Episode watchers: who is told everything of episodes, one after another."""

from __future__ import annotations

from typing import Protocol

from cbdsl.program.checked import CheckedProgram
from cbdsl.program.transition import Transition
from cbdsl.runtime.episode import EpisodeResult, Tick


class EpisodeWatcher(Protocol):
    """Watcher of episodes; the world waits while it is told."""

    def begin(self, program: CheckedProgram, stage: str, seed: int) -> None:
        """An episode of a program begins on a stage."""
        ...

    def note_transition(self, transition: Transition) -> None:
        """The state of a program changed."""
        ...

    def note_tick(self, tick: Tick) -> None:
        """A control tick is over, before its references are applied."""
        ...

    def note_end(self, result: EpisodeResult) -> None:
        """The episode ended, in whatever way."""
        ...
