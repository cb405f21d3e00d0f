"""Output of a run: text lines per transition, or one JSON object per episode."""

from __future__ import annotations

import json
from dataclasses import asdict

from cbdsl.program.transition import Transition
from cbdsl.runtime.episode_observer import EpisodeObserver
from cbdsl.runtime.episode_result import EpisodeResult


class Narration(EpisodeObserver):
    """Printer of each transition."""

    def note_transition(self, transition: Transition) -> None:
        """Print a transition."""
        narrate(transition)


def narrate(transition: Transition) -> None:
    """Print a transition, indented by how deep its program is used."""
    indent = "    " * transition.depth
    reward = f"  reward {transition.reward}" if transition.reward else ""
    unchanged = "  (no change)" if transition.state == transition.next_state else ""
    print(
        f"  {transition.time:6.2f} s  {indent}{transition.title}  "
        f"{transition.state} -> {transition.next_state}  {transition.action}{reward}{unchanged}",
        flush=True,
    )


def json_line(result: EpisodeResult) -> str:
    """Return an episode as a line of JSON; only ``wall_seconds`` depends on the machine."""
    row = asdict(result)
    row["transitions"] = len(result.actions)
    row["wall_seconds"] = round(result.wall_seconds, 3)
    return json.dumps(row, ensure_ascii=False)
