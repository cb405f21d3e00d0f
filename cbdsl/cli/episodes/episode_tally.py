"""Tally of the episodes of ``cb run``."""

from __future__ import annotations

from collections import Counter
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from cbdsl.runtime.episode_result import EpisodeResult


class EpisodeTally:
    """Sums of the episodes so far, which need the same memory for any number of them.

    Attributes:
        outcomes: Number of episodes by outcome.
        rewarded: Number of rewarded episodes.
        sim_seconds, wall_seconds: Simulated and wall time of all episodes, s.
    """

    def __init__(self) -> None:
        self.outcomes: Counter[str] = Counter()
        self.rewarded = 0
        self.sim_seconds = self.wall_seconds = 0.0
        self._last: tuple[EpisodeResult, ...] = ()

    def add(self, result: EpisodeResult, *, again: bool = False) -> None:
        """Add an episode, ``again`` in place of the last one."""
        before, self._last = self._last if again else (), (result,)
        for each, sign in (*((one, -1) for one in before), (result, 1)):
            self.outcomes[each.outcome] += sign
            self.rewarded += sign * each.rewarded
            self.sim_seconds += sign * each.sim_seconds
            self.wall_seconds += sign * each.wall_seconds

    def heading(self, seed: int, index: int, episodes: int) -> str:
        """Return the heading of an episode, with the remaining time."""
        if episodes == 1:
            return f"episode with seed {seed}"
        heading = f"episode {index + 1} of {episodes}, seed {seed}"
        if not index:
            return heading
        left = self.wall_seconds / index * (episodes - index)
        return f"{heading}, about {left // 60:.0f} min {left % 60:02.0f} s left"

    def summary(self, *, states_success: bool) -> str:
        """Return the number of successful episodes, or of rewarded ones without success states."""
        count = self.outcomes["success"] if states_success else self.rewarded
        verb = "succeeded" if states_success else "rewarded"
        simulated, wall = self.sim_seconds, self.wall_seconds
        return (
            f"{count} of {self.outcomes.total()} episodes {verb}; {simulated:.0f} s simulated "
            f"in {wall:.0f} s, {simulated / wall:.1f} times real time"
        )
