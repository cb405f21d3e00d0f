"""Episodes of ``cb run`` in several processes."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import TYPE_CHECKING

from cbdsl.api.evaluate import evaluate
from cbdsl.cli.arguments.workers import require_workers
from cbdsl.cli.episodes.episode_tally import EpisodeTally
from cbdsl.cli.episodes.simulation import needing_simulation
from cbdsl.cli.process.termination import termination_interrupts
from cbdsl.diagnostics.errors import UsageError

if TYPE_CHECKING:
    from cbdsl.api.requests.run_request import RunRequest
    from cbdsl.cli.arguments.run_options import RunOptions
    from cbdsl.runtime.episode_result import EpisodeResult


def run_parallel(
    request: RunRequest, options: RunOptions, tell: Callable[[EpisodeResult], None]
) -> EpisodeTally:
    """Run episodes in processes, and return their tally with the wall time.

    Args:
        request: Program with its robot and its stage.
        options: Options of the run.
        tell: Function called with each result, in the order of the seeds.

    Raises:
        UsageError: The backend is a real robot, the episodes depend on each other, or there are too
            many processes.
    """
    require_workers(options.workers)
    _require_independent(request, options.backend)
    tally, began = EpisodeTally(), time.monotonic()

    def take(result: EpisodeResult, _: bool) -> None:
        tally.add(result)
        tell(result)

    with termination_interrupts():
        evaluate(
            request,
            seed=options.seed,
            episodes=options.episodes,
            context=options.context,
            backend=options.backend,
            cameras=options.cameras,
            workers=options.workers,
            on_episode=take,
        )
    # The processes overlap.
    tally.wall_seconds = time.monotonic() - began
    return tally


def _require_independent(request: RunRequest, backend: str) -> None:
    with needing_simulation():
        from cbdsl.backends.backend import AttendedBackend, find_backend

        factory = find_backend(backend)
    if isinstance(factory, type) and issubclass(factory, AttendedBackend):
        raise UsageError(f"--workers is for simulators: backend '{backend}' has one robot")
    stage = request.stage
    if stage.world.persistent:
        raise UsageError(
            f"the world of stage '{stage.name}' goes on between episodes: leave out --workers"
        )
