"""``cbdsl.run``: episodes of a program."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from cbdsl.api.run_request import RunRequest
    from cbdsl.program.transition import Transition
    from cbdsl.runtime.episode import EpisodeResult, TickListener


def run(
    program: str | Path | RunRequest,
    *,
    seed: int = 0,
    episodes: int = 1,
    context: str | None = None,
    backend: str | None = None,
    cameras: str | None = None,
    on_transition: Callable[[Transition], None] | None = None,
    on_tick: TickListener | None = None,
) -> list[EpisodeResult]:
    """Run a program.

    Args:
        program: what ``load`` gave, or a file or name for it.
        seed: of the first episode; the others have the next ones.
        episodes: how many.
        context: one of the stage's contexts; drawn by their shares when ``None``.
        backend, cameras: as of ``open_robot``.
        on_transition: is told each change of state.
        on_tick: is told each control tick, with the observation and the signals.

    Returns:
        An outcome for each episode.

    Raises:
        DiagnosticsError: a document has errors.
        UsageError: something is not there, not installed, or does not fit.
    """
    from cbdsl.api.open_robot import open_robot

    with open_robot(program, backend=backend, cameras=cameras) as robot:
        return [
            robot.run(each, context=context, on_transition=on_transition, on_tick=on_tick)
            for each in range(seed, seed + episodes)
        ]
