"""``cbdsl.evaluate``: the success rate of a program, with its interval."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from itertools import takewhile
from pathlib import Path
from signal import SIG_IGN, SIGINT, signal
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from multiprocessing.synchronize import Event

    from cbdsl.api.requests.run_request import RunRequest
    from cbdsl.api.simulation.truth import Truth
    from cbdsl.runtime.episode_result import EpisodeResult


@dataclass(frozen=True)
class SuccessRate:
    """Episodes and their verdicts.

    Attributes:
        results: Result of each episode.
        successes: True for each successful episode.
    """

    results: tuple[EpisodeResult, ...]
    successes: tuple[bool, ...]

    @property
    def share(self) -> float:
        """Share of successful episodes, from 0 to 1."""
        return sum(self.successes) / len(self.successes)

    @property
    def interval(self) -> tuple[float, float]:
        """Exact 95 % interval of the share (Clopper-Pearson), from 0 to 1."""
        from cbdsl.numeric.proportion import exact_interval

        # The model is binomial: episodes are independent, with one probability of success. The
        # interval covers it in at least 95 % of evaluations, also if no or all episodes succeed. A
        # persistent world violates the assumption, because its episodes depend on each other.
        return exact_interval(sum(self.successes), len(self.successes))

    def __str__(self) -> str:
        low, high = (100 * end for end in self.interval)
        return f"{sum(self.successes)} of {len(self.successes)} ({low:.1f} to {high:.1f} %)"


def evaluate(
    program: str | Path | RunRequest,
    *,
    seed: int,
    episodes: int = 100,
    context: str | None = None,
    backend: str | None = None,
    cameras: str | None = None,
    workers: int = 1,
    judge: Callable[[EpisodeResult, Truth], bool] | None = None,
    on_episode: Callable[[EpisodeResult, bool], None] | None = None,
) -> SuccessRate:
    """Run held-out episodes of a program, without learning, and count the successes.

    An episode succeeds as in ``EpisodeResult``. With a ``judge``, the truth of the simulated world
    at the end of the episode decides instead.

    Args:
        program: Result of ``load``, or a file or name for it.
        seed: Seed of the first episode; the others have the following seeds. No episode that the
            program was learned or tuned with may have one of them.
        episodes: Number of episodes.
        context: Context of the stage; drawn by share if ``None``.
        backend: Name of the backend, as for ``open_robot``.
        cameras: Kind of cameras, as for ``open_robot``.
        workers: Number of parallel processes; no result but its wall time depends on it.
        judge: Function that returns whether an episode succeeded; with several workers, one of a
            module.
        on_episode: Function called with the result and the verdict of each episode, in the order
            of the seeds.

    Raises:
        DiagnosticsError: A document has errors.
        UsageError: An item is missing, not installed or unsuitable, there is no episode, or a judge
            needs a simulation.
    """
    from dataclasses import replace

    from cbdsl.api.load import load
    from cbdsl.api.requests.run_request import RunRequest
    from cbdsl.backends.engines import default_engine
    from cbdsl.diagnostics.errors import UsageError
    from cbdsl.yaml_text.library import Library

    if episodes < 1 or workers < 1:
        given = f"episodes={episodes}" if episodes < 1 else f"workers={workers}"
        raise UsageError(f"{given}: an evaluation needs at least one")
    request = program if isinstance(program, RunRequest) else load(program)
    chosen = default_engine() if backend is None else backend
    # Documents that were read have served their purpose: processes get the checked program alone.
    sent = replace(request, library=Library(request.library.here))
    campaign = _Campaign(sent, context, chosen, cameras, judge)
    seeds = range(seed, seed + episodes)
    results: list[EpisodeResult] = []
    successes: list[bool] = []
    for result, succeeded in campaign.run(seeds, min(workers, episodes)):
        results.append(result)
        successes.append(succeeded)
        if on_episode is not None:
            on_episode(result, succeeded)
    return SuccessRate(tuple(results), tuple(successes))


# Number of consecutive seeds of one job of a process: opening a robot takes longer than an episode.
_JOB = 10

Verdict = tuple["EpisodeResult", bool]

# Ends the workers after their present episode; set at the end of the evaluation.
_ended: Event


def _begin(ended: Event) -> None:
    """Begin a worker: an interrupt of a terminal reaches it, too, and its parent ends it."""
    global _ended
    _ended = ended
    signal(SIGINT, SIG_IGN)


@dataclass(frozen=True)
class _Campaign:
    """Evaluation without its seeds, for any process.

    Attributes:
        request: Program with its robot and its stage.
        context: Context of the stage; drawn by share if ``None``.
        backend: Name of the backend.
        cameras: Kind of cameras.
        judge: Function of the truth, if any.
    """

    request: RunRequest
    context: str | None
    backend: str
    cameras: str | None
    judge: Callable[[EpisodeResult, Truth], bool] | None

    def run(self, seeds: range, workers: int) -> Iterator[Verdict]:
        """Yield the verdicts on all seeds, in their order."""
        if workers == 1:
            yield from self.verdicts(seeds)
            return
        from concurrent.futures import ProcessPoolExecutor
        from multiprocessing import get_context

        # Short evaluations still occupy all workers.
        step = max(1, min(_JOB, len(seeds) // workers))
        parts = [seeds[first : first + step] for first in range(0, len(seeds), step)]
        # A forked process would inherit threads and simulators in the middle of their work. `map`
        # returns results in the order of the seeds.
        context = get_context("spawn")
        ended = context.Event()
        with ProcessPoolExecutor(
            workers, mp_context=context, initializer=_begin, initargs=(ended,)
        ) as pool:
            try:
                for part in pool.map(self.listed, parts):
                    yield from part
            finally:
                ended.set()

    def listed(self, seeds: range) -> list[Verdict]:
        """Return the verdicts on some seeds, in a worker; fewer if its parent ends."""
        return list(takewhile(lambda _: not _ended.is_set(), self.verdicts(seeds)))

    def verdicts(self, seeds: range) -> Iterator[Verdict]:
        """Yield the verdicts on some seeds, in this process."""
        from cbdsl.api.open_robot import open_robot
        from cbdsl.api.simulate import simulate

        # Only a judge needs the truth. Without one, each backend will do, even one without
        # simulation.
        if self.judge is None:
            with open_robot(self.request, backend=self.backend, cameras=self.cameras) as robot:
                for seed in seeds:
                    result = robot.run(seed, context=self.context)
                    yield result, result.succeeded
            return
        with simulate(self.request, backend=self.backend, cameras=self.cameras) as simulation:
            for seed in seeds:
                result = simulation.robot.run(seed, context=self.context)
                yield result, self.judge(result, simulation.truth)
