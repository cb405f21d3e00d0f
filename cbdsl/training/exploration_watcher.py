"""Exploration watchers: who is told what an exploration does and knows, and its episodes."""

from __future__ import annotations

from typing import Protocol

from cbdsl.learning.exploration import Exploration
from cbdsl.runtime.episode_watcher import EpisodeWatcher


class ExplorationWatcher(EpisodeWatcher, Protocol):
    """Watcher of an exploration; the world waits while it is told."""

    def note_choice(self, name: str) -> None:
        """An action was chosen, and is taken next."""
        ...

    def note_step(self, exploration: Exploration) -> None:
        """An action is over, of this exploration or of one that it goes on with."""
        ...
