"""Trials that are kept in a file as soon as they are over."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path
from typing import Generic, Protocol, TypeVar

from cbdsl.reproduction.kept_rows import KeptRows
from cbdsl.reproduction.trial_record import plain_data, read_record


class ThingTrial(Protocol):
    """A trial of things.

    Attributes:
        things: by which names.
        seed: of its episode.
    """

    @property
    def things(self) -> str: ...

    @property
    def seed(self) -> int: ...


Some = TypeVar("Some", bound=ThingTrial)


class KeptTrials(Generic[Some]):
    """Trials by things and seed; what is there already is not run again.

    Args:
        path: the file, a line of JSON for each trial; it need not be there.
        what: a digest of all that decides the outcome beside that; others are left alone.
        kind: class of the trials, a named tuple.
    """

    def __init__(self, path: Path, what: str, kind: type[Some]) -> None:
        self._rows, self._what = KeptRows(path), what
        self._known: dict[tuple[str, int], Some] = {}
        for row in self._rows:
            if not isinstance(row, dict) or row.pop("what", None) != what:
                continue
            try:
                trial = read_record(kind, row)
            except ValueError:
                continue
            self._known[trial.things, trial.seed] = trial

    def get(self, things: str, seed: int) -> Some | None:
        """A trial that was run, if it was."""
        return self._known.get((things, seed))

    def add(self, trial: Some) -> None:
        """Keep a trial."""
        self._known[trial.things, trial.seed] = trial
        self._rows.add({"what": self._what, **plain_data(trial)})


def kept_trials(
    path: Path,
    seeds: Mapping[str, Sequence[int]],
    digest: Callable[[str], str],
    kind: type[Some],
    run: Callable[[str, Sequence[int]], Iterable[Some]],
    progress: Callable[[int, int], None],
) -> dict[str, list[Some]]:
    """Trials of several things, those of a file and those that it lacks, which are run and added.

    Args:
        path: the file; see ``KeptTrials``.
        seeds: of the trials, by the things' names.
        digest: makes a digest of what decides the trials of some things.
        kind: class of the trials, a named tuple.
        run: runs the trials of some things; where none is missing it is not called.
        progress: hears of the trials that are there, and of all.

    Returns:
        Trials in the order of their seeds, by name.
    """
    trials: dict[str, list[Some]] = {}
    before, total = 0, sum(map(len, seeds.values()))
    for things, own in seeds.items():
        kept = KeptTrials(path, digest(things), kind)
        missing = [seed for seed in own if kept.get(things, seed) is None]
        done = before + len(own) - len(missing)
        for trial in run(things, missing) if missing else ():
            kept.add(trial)
            done += 1
            progress(done, total)
        trials[things] = [each for seed in own if (each := kept.get(things, seed)) is not None]
        before += len(own)
    return trials
