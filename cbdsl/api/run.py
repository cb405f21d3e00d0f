"""``cbdsl.run``: episodes of a program."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from cbdsl.api.requests.run_request import RunRequest
    from cbdsl.program.transition import Transition
    from cbdsl.runtime.episode_result import EpisodeResult
    from cbdsl.runtime.tick import Tick


def run(
    program: str | Path | RunRequest,
    *,
    seed: int = 0,
    episodes: int = 1,
    context: str | None = None,
    backend: str | None = None,
    cameras: str | None = None,
    on_transition: Callable[[Transition], None] | None = None,
    on_tick: Callable[[Tick], object] | None = None,
) -> list[EpisodeResult]:
    """Run a program.

    Args:
        program: Result of ``load``, or a file or name for it.
        seed: Seed of the first episode; the others have the following seeds.
        episodes: Number of episodes.
        context: Context of the stage; drawn by share if ``None``.
        backend: Name of the backend, as for ``open_robot``.
        cameras: Kind of cameras, as for ``open_robot``.
        on_transition: Function called with each change of state.
        on_tick: Function called at each control tick, with the observation and the signals.

    Returns:
        Outcome of each episode.

    Raises:
        DiagnosticsError: A document has errors.
        UsageError: An item is missing, not installed, or does not fit.
    """
    from cbdsl.api.open_robot import open_robot

    # One robot for all episodes, because opening it takes longer than an episode.
    with open_robot(program, backend=backend, cameras=cameras) as robot:
        return [
            robot.run(each, context=context, on_transition=on_transition, on_tick=on_tick)
            for each in range(seed, seed + episodes)
        ]
