"""Episodes of a program under watch of the simulated world's truth."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from typing import TYPE_CHECKING, Any

from cbdsl import load, simulate
from cbdsl_reproduction.judges.judge import BodyChoice, EpisodeVerdict, JudgedCondition

if TYPE_CHECKING:
    from cbdsl import EpisodeResult, RunRequest, SimulatedRobot, Transition, Truth


class Watch:
    """Observer of one episode, which no part of the robot sees.

    Args:
        simulated: Robot and the truth of its world.
        condition: Setting of the episode.
        body: Backend and cameras.
    """

    def __init__(
        self, simulated: SimulatedRobot, condition: JudgedCondition, body: BodyChoice
    ) -> None:
        self.truth: Truth = simulated.truth
        self.request: RunRequest = simulated.robot.request
        self.condition, self.body = condition, body
        self.begin()

    def begin(self) -> None:
        """Prepare for the episode."""

    def note(self, tick: Any) -> None:
        """Take in a control tick."""

    def hear(self, transition: Transition) -> None:
        """Take in a change of state."""

    def conclude(self, result: EpisodeResult) -> EpisodeVerdict:
        """Return the verdict."""
        raise NotImplementedError

    @property
    def shown(self) -> list[str]:
        """Names of the objects in the world that are no fixtures of the stage."""
        return [name for name in self.truth.objects if name not in self.request.stage.fixtures]

    def fingertips(self, *names: str) -> frozenset[tuple[str, str]]:
        """Return fingertips, as hand and finger, that touch any of some objects."""
        return frozenset(cell for name in names for cell in self.truth.touching(name))


def watched(
    watch: Callable[[SimulatedRobot, JudgedCondition, BodyChoice], Watch],
) -> Callable[[JudgedCondition, BodyChoice, Sequence[int]], Iterator[EpisodeVerdict]]:
    """Return the measure of episodes that a watch judges."""

    def measure(
        condition: JudgedCondition, body: BodyChoice, seeds: Sequence[int]
    ) -> Iterator[EpisodeVerdict]:
        request = load(condition.program, stage=condition.stage, values=condition.values)
        with simulate(request, backend=body.backend, cameras=body.cameras) as simulated:
            for seed in seeds:
                yield watch_episode(simulated, watch(simulated, condition, body), seed)

    return measure


def watch_episode(simulated: SimulatedRobot, watch: Watch, seed: int) -> EpisodeVerdict:
    """Run one episode under a watch, and return its verdict."""
    result = simulated.robot.run(
        seed,
        context=watch.condition.context,
        on_tick=watch.note,
        on_transition=watch.hear,
    )
    return watch.conclude(result)._replace(context=result.context)
