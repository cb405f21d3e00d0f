"""A control cycle of Dexter in ``reach ◁ touch``, from sensors to joint references, without images.

Six controllers act on eleven joints: touch, approach, orient and posture, above preshape and home.
The joints follow their references exactly, the ball's position is remembered, and the fingertips
feel a constant load. Each cycle is timed as a whole; a second series with a clock around every
stage gives the split. Run with ``python benchmarks/control_cycle.py``.
"""

from __future__ import annotations

import argparse
import json
import statistics
import sys
from collections.abc import Callable
from time import perf_counter

from ours import CYCLE_STAGES, CYCLES, DexterCycle
from stopwatch import Stopwatch


def run_cycles(cycle: DexterCycle, restarts: int, before: Callable[[], None],
               after: Callable[[float], None]) -> None:  # fmt: skip
    """Run series of cycles.

    Args:
        cycle: Cycle to run.
        restarts: Number of series.
        before: Function called before each cycle.
        after: Function called after each cycle with its time, us.
    """
    for _ in range(restarts):
        cycle.restart()
        # The restart itself processes the observation of tick 0.
        for tick in range(1, CYCLES):
            observation = cycle.observation(tick)
            before()
            start = perf_counter()
            cycle.tick(observation)
            after((perf_counter() - start) * 1e6)


def whole(cycle: DexterCycle, restarts: int) -> list[float]:
    """Return times of whole cycles, us."""
    times: list[float] = []
    run_cycles(cycle, restarts, lambda: None, times.append)
    return times


def split(cycle: DexterCycle, restarts: int) -> dict[str, list[float]]:
    """Return times by stage, us."""
    times: dict[str, list[float]] = {stage: [] for stage in CYCLE_STAGES}
    with Stopwatch(CYCLE_STAGES) as watch:

        def note(_: float) -> None:
            for stage, seconds in watch.seconds.items():
                times[stage].append(seconds * 1e6)

        run_cycles(cycle, restarts, watch.seconds.clear, note)
    return times


def main() -> None:
    """Time cycles and print medians."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--restarts", type=int, default=20, help="series of cycles")
    parser.add_argument("--json", action="store_true", help="print one JSON object")
    options = parser.parse_args()
    cycle = DexterCycle.of("reachtouch")
    times = {"cycle": whole(cycle, options.restarts), **split(cycle, options.restarts)}
    medians = {stage: round(statistics.median(values), 1) for stage, values in times.items()}
    if options.json:
        sys.stdout.write(json.dumps({"action": cycle.action, "microseconds": medians}) + "\n")
        return
    lines = [f"  {stage:12}{time:6.0f} us" for stage, time in medians.items()]
    sys.stdout.write("\n".join([f"{cycle.action}; medians", *lines]) + "\n")


if __name__ == "__main__":
    main()
