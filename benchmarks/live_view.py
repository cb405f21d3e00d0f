"""Cost of a live page per control tick, without a viewer and with a page that takes every frame.

    python benchmarks/live_view.py [--seed N] [--episodes N]

Prints the time of the view in each tick of `reachtouch` on the kinematic backend, beside the time
of the whole tick. Here a watched tick makes a frame each time; a run makes at most 30 per second.
"""

from __future__ import annotations

import argparse
import math
import statistics
import time

import cbdsl
from cbdsl.api.open_robot import OpenRobot
from cbdsl.backends.staging.world_state import GroundTruthProvider
from cbdsl.reporting.live import live_view
from cbdsl.reporting.live.feed import Feed
from cbdsl.reporting.live.live_view import LiveView
from cbdsl.reporting.live.transport import Transport
from cbdsl.runtime.program_composer import Composer
from cbdsl.runtime.tick import Tick


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--episodes", type=int, default=5)
    given = parser.parse_args()
    seeds = range(given.seed, given.seed + given.episodes)
    live_view._PAUSE = 0.0  # a frame in every tick
    with cbdsl.open_robot("reachtouch", backend="kinematic") as robot:
        robot.run(given.seed)  # one-time work is not measured
        for name, pages in (("nobody looks", 0), ("a page looks", 1)):
            own, whole = measured(robot, seeds, pages)
            print(
                f"{name}: {1e6 * statistics.median(own):.0f} us of a tick's "
                f"{1e6 * whole:.0f} us, median of {len(own)} ticks"
            )


def measured(robot: OpenRobot, seeds: range, pages: int) -> tuple[list[float], float]:
    """Return seconds that the view takes of each tick, and mean seconds of whole ticks."""
    feed, backend = Feed(), robot.backend
    assert isinstance(backend, GroundTruthProvider)
    view = LiveView(feed, Transport(math.inf), lambda: backend.truth, Composer())
    own: list[float] = []

    def on_tick(tick: Tick) -> None:
        began = time.perf_counter()
        view.note_tick(tick)
        own.append(time.perf_counter() - began)

    began = time.perf_counter()
    for seed in seeds:
        view.begin(robot.request.program, robot.request.stage.name, seed)
        if pages:
            with feed.page():
                robot.run(seed, on_tick=on_tick, on_transition=view.note_transition)
        else:
            robot.run(seed, on_tick=on_tick, on_transition=view.note_transition)
    return own, (time.perf_counter() - began) / len(own)


if __name__ == "__main__":
    main()
