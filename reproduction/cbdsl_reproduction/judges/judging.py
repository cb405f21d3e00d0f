"""Runs of judges: verdicts on all episodes, in this process or in parallel ones."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import Future, ProcessPoolExecutor, as_completed
from dataclasses import dataclass
from multiprocessing import get_context

from cbdsl_reproduction.judges.judge import BodyChoice, EpisodeVerdict, Judge, JudgedCondition

Verdicts = Mapping[str, Sequence[EpisodeVerdict]]
Progress = Callable[[int, int], None]
Finished = Callable[[JudgedCondition, Verdicts], None]

# Parts of a condition's episodes for each process, so that no process waits for long.
_PARTS = 4


@dataclass(frozen=True)
class Campaign:
    """Episodes of some conditions of a judge.

    Attributes:
        judge: Judge of the episodes.
        conditions: Conditions of the judge.
        body: Backend and cameras.
        seed: Seed of each condition's first episode; the others have the following seeds.
        episodes: Number of episodes of each condition.
    """

    judge: Judge
    conditions: tuple[JudgedCondition, ...]
    body: BodyChoice
    seed: int
    episodes: int

    @property
    def seeds(self) -> range:
        """Seeds of the episodes."""
        return range(self.seed, self.seed + self.episodes)

    def run(
        self, workers: int, progress: Progress, finished: Finished = lambda condition, own: None
    ) -> Verdicts:
        """Return verdicts by condition, ordered by seed and context.

        Args:
            workers: Number of parallel processes; no verdict depends on it.
            progress: Function called with the number of finished seeds, and of all.
            finished: Function called with each finished condition and its verdicts.
        """
        verdicts: dict[str, list[EpisodeVerdict]] = {
            condition.name: [] for condition in self.conditions
        }
        total = len(self.conditions) * self.episodes
        by_name = {condition.name: condition for condition in self.conditions}
        done: Counter[str] = Counter()
        for name, count, part in self._parts(workers):
            verdicts[name] += part
            done[name] += count
            if done[name] == self.episodes:
                verdicts[name].sort(key=lambda verdict: (verdict.seed, verdict.context))
                finished(by_name[name], verdicts)
            progress(done.total(), total)
        return verdicts

    def _parts(self, workers: int) -> Iterator[tuple[str, int, list[EpisodeVerdict]]]:
        """Yield condition, number of seeds and verdicts of each part of the campaign."""
        if workers == 1 or self.judge.is_real_time:
            for condition in self.conditions:
                yield condition.name, self.episodes, self._measured(condition, self.seeds)
            return
        with ProcessPoolExecutor(workers, mp_context=get_context("spawn")) as pool:
            step = min(self.episodes, _PARTS * workers)
            jobs: dict[Future[list[EpisodeVerdict]], tuple[str, int]] = {}
            for condition in self.conditions:
                # Judges hold closures, which cannot be pickled. A process finds its judge by name.
                for k in range(step):
                    seeds = self.seeds[k::step]
                    job = pool.submit(_measure, self.judge.name, condition.name, self.body, seeds)
                    jobs[job] = condition.name, len(seeds)
            for job in as_completed(jobs):
                yield *jobs[job], job.result()

    def _measured(self, condition: JudgedCondition, seeds: Sequence[int]) -> list[EpisodeVerdict]:
        return list(self.judge.measure(condition, self.body, seeds))


def _measure(
    judge: str, condition: str, body: BodyChoice, seeds: Sequence[int]
) -> list[EpisodeVerdict]:
    """Return verdicts of some seeds, in a process of its own."""
    from cbdsl_reproduction.judges.registry import JUDGES

    chosen = JUDGES[judge]
    (measured,) = (each for each in chosen.conditions if each.name == condition)
    return list(chosen.measure(measured, body, seeds))
