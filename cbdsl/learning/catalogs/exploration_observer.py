"""Observers of explorations, their knowledge and their episodes."""

from __future__ import annotations

from cbdsl.learning.catalogs.exploration import Exploration
from cbdsl.runtime.episode_observer import EpisodeObserver


class ExplorationObserver(EpisodeObserver):
    """Observer of an exploration; the world waits during each call."""

    def note_choice(self, name: str) -> None:
        """Note that an action was chosen and runs next."""

    def note_step(self, exploration: Exploration) -> None:
        """Note that an action is over, whether new or replayed from the journal."""
