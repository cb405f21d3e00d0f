"""Accuracy of putting down a held object: ``take_and_put_down``, judged by the simulator.

A report of contact is the moment at which the controller that waits for an onset becomes defined.
It is false if the held object touched nothing but the hand within 0.1 s before. It is missed if the
object touched something for 1 s without a report. An object is placed if it stands within 2 cm of
its place in the hand, by itself, at rest, and tilted by less than 10 degrees. Shares are of the
objects that were held off the table, with exact (Clopper-Pearson) 95 % intervals. The exit status
is 1 if a target is missed.

    python benchmarks/placing.py --episodes 200 --seed 5000000 [--left] [--json]
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
import pybullet  # noqa: TID251 (the judge, not the robot)
from numpy.typing import NDArray

from cbdsl.numeric.proportion import exact_interval

Floats = NDArray[np.float64]

PROGRAM = "take_and_put_down"
# Shares of objects that are put down correctly, and of contacts that may be missed.
PLACED, MISSED = 0.95, 0.02
CLOSE, FLAT, STILL = 0.02, 10.0, 0.01  # m, deg, m/s
# Ticks of 1/60 s within which a touch counts as reported, and after which it counts as missed.
BEFORE, LONG = 6, 60


class Setting(NamedTuple):
    """Way to put objects down.

    Attributes:
        stage: Stage of the objects; ``None`` for the program's own.
        values: Values of the program's parameters.
        cameras: ``rendered`` or ``ideal``.
    """

    stage: str | None
    values: Mapping[str, str]
    cameras: str


class Episode(NamedTuple):
    """Episode with one object, taken, lifted and put down.

    Attributes:
        seed: Seed of the episode.
        thing: Form of the object.
        held: True if it was in the hand when it was to be put down.
        placed: True if it stands at its goal.
        reported: True if contact was reported.
        false: True if it touched nothing then.
        missed: True if it touched something for long without a report.
        idle_ticks: Ticks of a report in which it touched nothing.
        error: Horizontal distance from the place above which it was held, mm.
        tilt: Tilt of its upright axis, deg; 0 for balls.
        seconds: Simulated time.
        ending: Ending of the program.
    """

    seed: int
    thing: str
    held: bool
    placed: bool
    reported: bool
    false: bool
    missed: bool
    idle_ticks: int
    error: float
    tilt: float
    seconds: float
    ending: str


class _Judge:
    """Watches one episode by the simulator's truth, which no controller sees."""

    def __init__(self, truth: Any) -> None:
        self._truth = truth
        self.thing = ""
        #: Place of the object in the hand, off the table, before it is put down.
        self.held: Floats | None = None
        self._begun = False
        self.reported = self.false = self.missed = False
        self.idle_ticks = self._touched = 0
        self._last_touch = -BEFORE - 1
        self._tick = 0

    def note(self, tick: Any) -> None:
        """Take in a tick."""
        self._tick += 1
        if not self.thing:
            (self.thing,) = (name for name in self._truth.names() if name != "table")
            self._upright = self._truth.pose(self.thing).rotation[:, 2]
        run = tick.run.children["put_down"]
        if run.predicate == "X":
            return
        touches = self.touches()
        if not self._begun:
            self._begun = True
            if not touches and self._truth.touched(self.thing):
                self.held = self._truth.pose(self.thing).position
        if touches:
            self._last_touch = self._tick
        letter = run.state[run.program.members.index("place")]
        if letter in "01":
            self._judge_report(touches)
        elif run.action is not None and run.action.name.startswith("lower") and not self.reported:
            self._touched += touches
            self.missed |= self._touched >= LONG

    def _judge_report(self, touches: bool) -> None:
        if not self.reported:
            self.reported = True
            self.false = self._tick - self._last_touch > BEFORE
        self.idle_ticks += not touches

    def touches(self) -> bool:
        """Return True if the object presses on anything but the robot."""
        truth = self._truth
        points = pybullet.getContactPoints(truth.bodies[self.thing], physicsClientId=truth.client)
        return any(point[2] != truth.robot.id and point[9] > 0.0 for point in points)

    def conclude(self, seed: int, result: Any) -> Episode:
        """Return the outcome of an episode."""
        pose = self._truth.pose(self.thing)
        held = self.held is not None
        error = math.nan if self.held is None else math.dist(pose.position[:2], self.held[:2])
        cosine = min(1.0, float(pose.rotation[:, 2] @ self._upright))
        tilt = 0.0 if self.thing == "ball" else math.degrees(math.acos(cosine))
        rests = float(np.linalg.norm(self._truth.velocity(self.thing))) < STILL
        alone = self.touches() and not self._truth.touched(self.thing)
        placed = held and rests and alone and error < CLOSE and tilt < FLAT
        return Episode(
            seed, self.thing, held, placed and result.outcome == "success",
            self.reported, self.false, self.missed and not self.reported, self.idle_ticks,
            round(1e3 * error, 1), round(tilt, 1), result.sim_seconds, result.ending,
        )  # fmt: skip


def run_episodes(setting: Setting, seeds: Iterable[int]) -> list[Episode]:
    """Put some things down, in this process."""
    from cbdsl.api.run_request import read_request
    from cbdsl.backends.staging.world_state import GroundTruthProvider
    from cbdsl.cli.simulation import simulation
    from cbdsl.runtime.episode import Runner

    request = read_request(PROGRAM, setting.stage, None, setting.values)
    episodes = []
    with simulation(request, "bullet", cameras=setting.cameras) as (backend, kinematics):
        runner = Runner(request.robot, kinematics, request.program, backend)
        for seed in seeds:
            assert isinstance(backend, GroundTruthProvider)
            judge = _Judge(backend.truth)
            result = runner.run(request.stage, seed, on_tick=judge.note)
            episodes.append(judge.conclude(seed, result))
    return episodes


def summarise(episodes: Sequence[Episode]) -> dict[str, Any]:
    """Return the result, for the objects that were held when they were to be put down."""
    held = [each for each in episodes if each.held]
    placed = [each for each in held if each.placed]
    reported = [each for each in held if each.reported]
    false = [each.seed for each in reported if each.false]
    missed = [each.seed for each in held if each.missed]
    return {
        "episodes": len(episodes),
        "held": len(held),
        "placed": len(placed),
        "placed_interval": _interval(len(placed), len(held)),
        "reports": len(reported),
        "false": false,
        "missed": missed,
        "missed_interval": _interval(len(missed), len(held)),
        "idle_ticks": sum(each.idle_ticks for each in held),
        "error_mm": _quantiles([each.error for each in placed]),
        "tilt_deg": _quantiles([each.tilt for each in placed]),
        "sim_seconds": round(sum(each.seconds for each in episodes) / len(episodes), 1),
        "amiss": [(e.seed, e.thing, e.error, e.tilt, e.ending) for e in episodes if not e.placed],
        "met": bool(
            held
            and not false
            and len(missed) <= MISSED * len(held)
            and len(placed) >= PLACED * len(held)
        ),
    }


def _interval(successes: int, count: int) -> list[float]:
    return [round(bound, 3) for bound in exact_interval(successes, count)] if count else [0.0, 1.0]


def _quantiles(values: Sequence[float]) -> list[float]:
    """Return median, nine of ten, largest."""
    if not values:
        return []
    return [round(float(each), 1) for each in np.quantile(values, [0.5, 0.9, 1.0])]


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--episodes", type=int, default=200)
    parser.add_argument("--seed", type=int, default=20000)
    parser.add_argument("--workers", type=int, default=os.cpu_count() or 1)
    parser.add_argument("--stage", help="another one than the program's own")
    parser.add_argument("--left", action="store_true", help="with the left hand")
    parser.add_argument("--cameras", default="rendered", choices=["rendered", "ideal"])
    parser.add_argument("--each", action="store_true", help="print every episode")
    parser.add_argument("--json", action="store_true")
    options = parser.parse_args()
    side = "left" if options.left else "right"
    stage = options.stage or ("table_left" if options.left else None)
    setting = Setting(stage, {"arm": f"{side}_arm", "hand": f"{side}_hand"}, options.cameras)
    seeds = range(options.seed, options.seed + options.episodes)
    parts = [seeds[k :: options.workers] for k in range(options.workers)]
    with ProcessPoolExecutor(options.workers) as pool:
        done = pool.map(run_episodes, [setting] * len(parts), parts)
        episodes = sorted(each for some in done for each in some)
    row = summarise(episodes)
    for each in episodes if options.each else ():
        print(json.dumps(each._asdict()))
    print(json.dumps(row) if options.json else "\n".join(f"{k}: {v}" for k, v in row.items()))
    sys.exit(not row["met"])


if __name__ == "__main__":
    main()
