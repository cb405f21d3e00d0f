"""Trials that are stored in a file as soon as they end."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path
from typing import Generic, Protocol, TypeVar

from cbdsl_reproduction.kept_rows import KeptRows
from cbdsl_reproduction.trial_record import plain_data, read_record


class ThingTrial(Protocol):
    """Trial with objects.

    Attributes:
        things: Names of the objects, as one text.
        seed: Seed of its episode.
    """

    @property
    def things(self) -> str: ...

    @property
    def seed(self) -> int: ...


Some = TypeVar("Some", bound=ThingTrial)


class KeptTrials(Generic[Some]):
    """Trials by objects and seed; stored trials are not run again.

    Args:
        path: File with a line of JSON for each trial; it need not exist.
        digest: Digest of all other inputs of the trials; trials with other digests are ignored.
        kind: Class of the trials, a named tuple.
    """

    def __init__(self, path: Path, digest: str, kind: type[Some]) -> None:
        self._rows, self._digest = KeptRows(path), digest
        self._known: dict[tuple[str, int], Some] = {}
        for row in self._rows:
            # Rows with another digest belong to other documents.
            # They stay in the file, for these documents.
            if not isinstance(row, dict) or row.pop("what", None) != digest:
                continue
            try:
                trial = read_record(kind, row)
            # A row without the fields of the class cannot be read, and its trial is run again.
            except ValueError:
                continue
            self._known[trial.things, trial.seed] = trial

    def get(self, things: str, seed: int) -> Some | None:
        """Return a stored trial, or ``None``."""
        return self._known.get((things, seed))

    def add(self, trial: Some) -> None:
        """Store a trial."""
        self._known[trial.things, trial.seed] = trial
        self._rows.add({"what": self._digest, **plain_data(trial)})


def kept_trials(
    path: Path,
    seeds: Mapping[str, Sequence[int]],
    digest: Callable[[str], str],
    kind: type[Some],
    run: Callable[[str, Sequence[int]], Iterable[Some]],
    progress: Callable[[int, int], None],
) -> dict[str, list[Some]]:
    """Return the trials of several objects from a file, after running and adding missing ones.

    Args:
        path: File of trials; see ``KeptTrials``.
        seeds: Seeds of the trials, by the objects' names.
        digest: Function that returns the digest of all inputs of the trials of some objects.
        kind: Class of the trials, a named tuple.
        run: Function that runs trials of some objects; it is called only for missing trials.
        progress: Callback for the numbers of finished and of all trials.

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
