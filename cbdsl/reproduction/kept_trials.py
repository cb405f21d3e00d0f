"""Trials of impedance that are kept in a file as soon as they are over."""

from __future__ import annotations

import json
from pathlib import Path

from cbdsl.reproduction.impedance_trials import ImpedanceTrial


class KeptTrials:
    """Trials by pair and seed; what is there already is not run again.

    Args:
        path: the file, a line of JSON for each trial; it need not be there.
        what: a digest of all that decides the outcome beside pair and seed; others are left alone.
    """

    def __init__(self, path: Path, what: str) -> None:
        self._path, self._what = path, what
        self._known: dict[tuple[str, int], ImpedanceTrial] = {}
        text = path.read_text(encoding="utf-8") if path.exists() else ""
        if text and not text.endswith("\n"):
            with path.open("a", encoding="utf-8") as file:
                file.write("\n")  # so that the next one has a line of its own
        for line in text.splitlines():
            try:
                row = json.loads(line)
                if row.pop("what") != what:
                    continue
                trial = ImpedanceTrial.from_data(row)
            except ValueError:
                continue  # cut off when the process was ended
            self._known[trial.pair, trial.seed] = trial

    def get(self, pair: str, seed: int) -> ImpedanceTrial | None:
        """A trial that was run, if it was."""
        return self._known.get((pair, seed))

    def add(self, trial: ImpedanceTrial) -> None:
        """Keep a trial."""
        self._known[trial.pair, trial.seed] = trial
        self._path.parent.mkdir(parents=True, exist_ok=True)
        with self._path.open("a", encoding="utf-8") as file:
            file.write(json.dumps({"what": self._what, **trial.as_data()}) + "\n")
