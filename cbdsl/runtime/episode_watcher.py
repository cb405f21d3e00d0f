"""Episode watchers: observers of one episode after another."""

from __future__ import annotations

from typing import Protocol

from cbdsl.program.checked import CheckedProgram
from cbdsl.program.transition import Transition
from cbdsl.runtime.episode import EpisodeResult, Tick


class EpisodeWatcher(Protocol):
    """Observer of episodes; the world waits during each call."""

    def begin(self, program: CheckedProgram, stage: str, seed: int) -> None:
        """Note that an episode of a program begins on a stage."""
        ...

    def note_transition(self, transition: Transition) -> None:
        """Note that the state of a program changed."""
        ...

    def note_tick(self, tick: Tick) -> None:
        """Note that a control tick is over, before its references are applied."""
        ...

    def note_end(self, result: EpisodeResult) -> None:
        """Note that the episode ended, for any reason."""
        ...
