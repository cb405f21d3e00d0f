"""Accuracy of placing an object on a seen pad: ``deliver``, judged by the simulator.

``pick_and_place`` is rewarded falsely if the object then touches nothing but the hand, or touched
nothing else within 0.1 s before. An object is placed if it ends within 2 cm of the pad's
centre, by itself, at rest, and tilted by less than 10 degrees. Shares have exact
(Clopper-Pearson) 95 % intervals. The exit status is 1 if a target is missed.

    python benchmarks/pick_and_place.py --episodes 100 --seed 8000000 [--only ball,cube]
        [--backend mujoco] [--cameras ideal] [--each] [--json]
"""

from __future__ import annotations

import argparse
import json
import math
import os
import sys
from collections.abc import Iterable, Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from cbdsl.numeric.proportion import exact_interval

Floats = NDArray[np.float64]

PROGRAM = "deliver"
# Shares of all episodes in which the object is placed.
TARGETS: Mapping[str, float] = {"ball": 0.97, "cube": 0.95, "cylinder": 0.95, "box": 0.95}
CLOSE, FLAT, STILL = 0.02, 10.0, 0.01  # m, deg, m/s
# Ticks of 1/60 s within which a touch counts as one that was felt.
BEFORE = 6


class Setting(NamedTuple):
    """Way to place objects.

    Attributes:
        thing: Name of the object; the context of the stage has the same name.
        stage: Stage of the object; ``None`` for the program's own.
        backend: Name of the engine.
        cameras: ``rendered`` or ``ideal``.
    """

    thing: str
    stage: str | None
    backend: str
    cameras: str | None


class Episode(NamedTuple):
    """Episode with one object, taken and placed.

    Attributes:
        seed: Seed of the episode.
        thing: Name of the object.
        placed: True if it stands at its goal.
        rewarded: True if the robot felt that the place bears it.
        false: True if it touched nothing but the hand then.
        error: Horizontal distance from the pad's centre at the end, mm.
        drop: The same distance at the reward, mm; negative without a reward.
        tilt: Tilt of its upright axis, deg; 0 for balls.
        lift: Most height above its first place, mm.
        seconds: Simulated time.
        ending: Ending of the program.
    """

    seed: int
    thing: str
    placed: bool
    rewarded: bool
    false: bool
    error: float
    drop: float
    tilt: float
    lift: float
    seconds: float
    ending: str


class _Judge:
    """Watches one episode by the simulator's truth, which no controller sees."""

    def __init__(self, truth: Any, thing: str) -> None:
        self._truth, self._thing = truth, thing
        self._begun = self.rewarded = self.false = False
        self._tick, self._last_touch = 0, -BEFORE - 1
        self._highest, self._drop = -math.inf, -1.0

    def note(self, tick: Any) -> None:
        """Take in a tick."""
        pose = self._truth.pose(self._thing)
        if not self._begun:
            self._begun = True
            self._upright, self._height = pose.rotation[:, 2], pose.position[2]
        self._tick += 1
        self._highest = max(self._highest, float(pose.position[2]))
        if self.touches():
            self._last_touch = self._tick

    def hear(self, transition: Any) -> None:
        """Take in a transition."""
        if transition.program == "pick_and_place" and transition.reward:
            self.rewarded = True
            self.false = self._tick - self._last_touch > BEFORE
            self._drop = 1e3 * self._distance()

    def _distance(self) -> float:
        """Return the horizontal distance from the pad's centre, m."""
        pad = self._truth.pose("pad").position
        return math.dist(self._truth.pose(self._thing).position[:2], pad[:2])

    def touches(self) -> bool:
        """Return True if the object presses on anything but the robot."""
        return bool(self._truth.neighbours(self._thing))

    def conclude(self, seed: int, result: Any) -> Episode:
        """Return the outcome of an episode."""
        pose = self._truth.pose(self._thing)
        cosine = min(1.0, float(pose.rotation[:, 2] @ self._upright))
        tilt = 0.0 if self._thing == "ball" else math.degrees(math.acos(cosine))
        rests = float(np.linalg.norm(self._truth.velocity(self._thing))) < STILL
        alone = self.touches() and not self._truth.touched(self._thing)
        error = self._distance()
        placed = rests and alone and error < CLOSE and tilt < FLAT
        return Episode(
            seed, self._thing, placed and result.outcome == "success", self.rewarded, self.false,
            round(1e3 * error, 1), round(self._drop, 1), round(tilt, 1),
            round(1e3 * (self._highest - self._height), 1), result.sim_seconds, result.ending,
        )  # fmt: skip


def run_episodes(setting: Setting, seeds: Iterable[int]) -> list[Episode]:
    """Place some things, in this process."""
    from cbdsl.api.run_request import read_request
    from cbdsl.backends.staging.world_state import GroundTruthProvider
    from cbdsl.cli.simulation import simulation
    from cbdsl.runtime.episode import Runner

    request = read_request(PROGRAM, setting.stage, None, {})
    episodes = []
    with simulation(request, setting.backend, cameras=setting.cameras) as (backend, kinematics):
        runner = Runner(request.robot, kinematics, request.program, backend)
        for seed in seeds:
            assert isinstance(backend, GroundTruthProvider)
            judge = _Judge(backend.truth, setting.thing)
            result = runner.run(request.stage, seed, setting.thing, judge.hear, judge.note)
            episodes.append(judge.conclude(seed, result))
    return episodes


def summarise(thing: str, episodes: Sequence[Episode]) -> dict[str, Any]:
    """Return one row of the table."""
    placed = [each for each in episodes if each.placed]
    low, high = exact_interval(len(placed), len(episodes))
    false = [each.seed for each in episodes if each.false]
    return {
        "thing": thing,
        "episodes": len(episodes),
        "placed": len(placed),
        "interval": [round(low, 3), round(high, 3)],
        "target": TARGETS[thing],
        "rewarded": sum(each.rewarded for each in episodes),
        "false": false,
        "error_mm": _quantiles([each.error for each in placed]),
        "tilt_deg": _quantiles([each.tilt for each in placed]),
        "lift_mm": _quantiles([each.lift for each in placed]),
        "sim_seconds": round(sum(each.seconds for each in episodes) / len(episodes), 1),
        "amiss": [(e.seed, e.drop, e.error, e.tilt, e.ending) for e in episodes if not e.placed],
        "met": bool(not false and len(placed) >= TARGETS[thing] * len(episodes)),
    }


def _quantiles(values: Sequence[float]) -> list[float]:
    """Return median, nine of ten, largest."""
    if not values:
        return []
    return [round(float(each), 1) for each in np.quantile(values, [0.5, 0.9, 1.0])]


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--episodes", type=int, default=100, help="of each thing")
    parser.add_argument("--seed", type=int, default=20000)
    parser.add_argument("--only", default=",".join(TARGETS), help="some of the things")
    parser.add_argument("--stage", help="another one than the program's own")
    parser.add_argument("--backend", default="bullet", choices=["bullet", "mujoco"])
    parser.add_argument("--cameras", choices=["rendered", "ideal"])
    parser.add_argument("--workers", type=int, default=os.cpu_count() or 1)
    parser.add_argument("--each", action="store_true", help="print every episode")
    parser.add_argument("--json", action="store_true")
    options = parser.parse_args()
    things = options.only.split(",")
    seeds = range(options.seed, options.seed + options.episodes)
    workers = options.workers
    jobs = [
        (Setting(thing, options.stage, options.backend, options.cameras), seeds[k::workers])
        for thing in things
        for k in range(workers)
    ]
    with ProcessPoolExecutor(workers) as pool:
        done = [each for some in pool.map(run_episodes, *zip(*jobs, strict=True)) for each in some]
    rows = []
    for thing in things:
        own = sorted(each for each in done if each.thing == thing)
        for each in own if options.each else ():
            print(json.dumps(each._asdict()))
        rows.append(summarise(thing, own))
        if not options.json:
            print("\n".join(f"{k}: {v}" for k, v in rows[-1].items()), flush=True)
    if options.json:
        print(json.dumps(rows))
    sys.exit(not all(row["met"] for row in rows))


if __name__ == "__main__":
    main()
