"""Episodes that are kept in a file as soon as they are over."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import asdict
from pathlib import Path
from typing import Any, NamedTuple

from cbdsl.reproduction.kept_rows import KeptRows
from cbdsl.runtime.episode import EpisodeResult


class PlayedEpisode(NamedTuple):
    """An episode, and what the simulator's truth says of it.

    Attributes:
        result: its outcome.
        done: whether its program came to its end: rewarded, succeeded or at rest.
        slip: how far what a hand carried moved in that hand at most, m; ``None`` where nothing
            was carried.
    """

    result: EpisodeResult
    done: bool
    slip: float | None = None


class KeptEpisodes:
    """Outcomes by what was run and by seed; what is there already is not run again.

    Args:
        path: the file, a line of JSON for each episode; it need not be there.
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
                continue  # damaged: what it held is run again

    def run(self, what: str, seed: int, run: Callable[[], PlayedEpisode]) -> PlayedEpisode:
        """The outcome of an episode, from the file or by running it.

        Args:
            what: a digest of all that decides the outcome beside the seed.
            seed: of the episode.
            run: runs it.
        """
        known = self._known.get((what, seed))
        if known is not None:
            return known
        played = run()
        self._rows.add({"what": what, **played._asdict(), "result": asdict(played.result)})
        self._known[what, seed] = played
        return played


def _result(row: dict[str, Any]) -> EpisodeResult:
    lists = {key: tuple(value) for key, value in row.items() if isinstance(value, list)}
    return EpisodeResult(**{**row, **lists})
