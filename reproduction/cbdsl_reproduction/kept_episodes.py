"""Episodes that are stored in a file as soon as they end."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import asdict
from pathlib import Path
from typing import Any, NamedTuple

from cbdsl import EpisodeResult
from cbdsl_reproduction.kept_rows import KeptRows


class PlayedEpisode(NamedTuple):
    """Result of an episode, beside ground truth of the simulator, which a result never holds.

    Attributes:
        result: Outcome of the episode.
        done: True if its program completed: rewarded, succeeded or at rest.
        slip: Largest displacement of a carried object within the hand, m; ``None`` if no object
            was carried.
    """

    result: EpisodeResult
    done: bool
    slip: float | None = None


class KeptEpisodes:
    """Outcomes of episodes by digest and seed; stored episodes are not run again.

    Args:
        path: File with a line of JSON for each episode; it need not exist.
    """

    def __init__(self, path: Path) -> None:
        self._rows = KeptRows(path)
        self._known: dict[tuple[str, int], PlayedEpisode] = {}
        for row in self._rows:
            try:
                result = _result(row["result"])
                played = PlayedEpisode(result, row["done"], row["slip"])
                self._known[row["what"], result.seed] = played
            except (AttributeError, KeyError, TypeError):
                continue  # damaged row: its episode is run again

    def run(self, digest: str, seed: int, run: Callable[[], PlayedEpisode]) -> PlayedEpisode:
        """Return the outcome of an episode, from the file or by running it.

        Args:
            digest: Digest of all inputs of the episode except the seed.
            seed: Seed of the episode.
            run: Function that runs the episode.
        """
        known = self._known.get((digest, seed))
        if known is not None:
            return known
        played = run()
        self._rows.add({"what": digest, **played._asdict(), "result": asdict(played.result)})
        self._known[digest, seed] = played
        return played


def _result(row: dict[str, Any]) -> EpisodeResult:
    lists = {key: tuple(value) for key, value in row.items() if isinstance(value, list)}
    return EpisodeResult(**{**row, **lists})
