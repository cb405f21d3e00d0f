"""Episodes that are kept in a file as soon as they are over."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import asdict
from pathlib import Path
from typing import Any

from cbdsl.runtime.episode import EpisodeResult


class KeptEpisodes:
    """Outcomes by what was run and by seed; what is there already is not run again.

    Args:
        path: the file, a line of JSON for each episode; it need not be there.
    """

    def __init__(self, path: Path) -> None:
        self._path = path
        self._known: dict[tuple[str, int], EpisodeResult] = {}
        lines = path.read_text(encoding="utf-8").splitlines() if path.exists() else []
        for line in lines:
            try:
                row = json.loads(line)
            except ValueError:
                continue  # cut off when the process was ended
            result = _result(row["result"])
            self._known[row["what"], result.seed] = result

    def run(self, what: str, seed: int, run: Callable[[], EpisodeResult]) -> EpisodeResult:
        """The outcome of an episode, from the file or by running it.

        Args:
            what: a digest of all that decides the outcome beside the seed.
            seed: of the episode.
            run: runs it.
        """
        known = self._known.get((what, seed))
        if known is not None:
            return known
        result = run()
        with self._path.open("a", encoding="utf-8") as file:
            file.write(json.dumps({"what": what, "result": asdict(result)}) + "\n")
        self._known[what, seed] = result
        return result


def _result(row: dict[str, Any]) -> EpisodeResult:
    lists = {key: tuple(value) for key, value in row.items() if isinstance(value, list)}
    return EpisodeResult(**{**row, **lists})
