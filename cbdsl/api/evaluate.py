"""``cbdsl.evaluate``: the success rate of a program, with its interval."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from cbdsl.api.run_request import RunRequest
    from cbdsl.api.truth import Truth
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
    judge: Callable[[EpisodeResult, Truth], bool] | None = None,
    on_episode: Callable[[EpisodeResult, bool], None] | None = None,
) -> SuccessRate:
    """Run held-out episodes of a program, without learning, and count the successes.

    An episode succeeds if it is rewarded or reaches a state of success. With a ``judge``, the truth
    of the simulated world at the end of the episode decides instead.

    Args:
        program: Result of ``load``, or a file or name for it.
        seed: Seed of the first episode; the others have the following seeds. No episode that the
            program was learned or tuned with may have one of them.
        episodes: Number of episodes.
        context: Context of the stage; drawn by share if ``None``.
        backend: Name of the backend, as for ``open_robot``.
        cameras: Kind of cameras, as for ``open_robot``.
        judge: Function that returns whether an episode succeeded.
        on_episode: Function called with the result and the verdict of each episode.

    Raises:
        DiagnosticsError: A document has errors.
        UsageError: An item is missing, not installed or unsuitable, there is no episode, or a judge
            needs a simulation.
    """
    from cbdsl.api.open_robot import open_robot
    from cbdsl.api.simulate import simulate
    from cbdsl.diagnostics.errors import UsageError

    if episodes < 1:
        raise UsageError(f"episodes={episodes}: an evaluation needs at least one")
    results: list[EpisodeResult] = []
    successes: list[bool] = []

    def note(result: EpisodeResult, succeeded: bool) -> None:
        results.append(result)
        successes.append(succeeded)
        if on_episode is not None:
            on_episode(result, succeeded)

    seeds = range(seed, seed + episodes)
    if judge is None:
        with open_robot(program, backend=backend, cameras=cameras) as robot:
            for each in seeds:
                result = robot.run(each, context=context)
                note(result, result.rewarded or result.outcome == "success")
    else:
        with simulate(program, backend=backend, cameras=cameras) as simulation:
            for each in seeds:
                result = simulation.robot.run(each, context=context)
                note(result, judge(result, simulation.truth))
    return SuccessRate(tuple(results), tuple(successes))
