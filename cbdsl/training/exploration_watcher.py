"""Exploration watchers: observers of an exploration, its knowledge and its episodes."""

from __future__ import annotations

from typing import Protocol

from cbdsl.learning.exploration import Exploration
from cbdsl.runtime.episode_watcher import EpisodeWatcher


class ExplorationWatcher(EpisodeWatcher, Protocol):
    """Observer of an exploration; the world waits during each call."""

    def note_choice(self, name: str) -> None:
        """Note that an action was chosen and runs next."""
        ...

    def note_step(self, exploration: Exploration) -> None:
        """Note that an action is over, whether new or replayed from the journal."""
        ...
