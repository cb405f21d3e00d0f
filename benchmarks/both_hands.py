"""How often both hands take a large thing from the table, judged by the simulator's contacts.

``take_with_both`` on balls of 12 to 15 cm radius and boxes of 30 cm. A reward counts as one with
contact where both hands pressed on the thing within 0.1 s before. A thing is lifted where it is
higher by 5 cm at the end, and borne by nothing but the hands. Shares come with exact
(Clopper-Pearson) 95 % intervals. Exits with 1 where a target is missed.

    python benchmarks/both_hands.py --episodes 40 --seed 5000000 [--only ball] [--json]
"""

from __future__ import annotations

import argparse
import json
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

THINGS = ("ball", "box")
# Share of rewarded objects, and the height from which an object counts as lifted, m.
REWARDED, LIFTED = 0.90, 0.05
# Ticks of 1/60 s in which a hand has to have pressed on the object before a reward.
BEFORE = 6


class Episode(NamedTuple):
    """Episode with one large object.

    Attributes:
        seed: Seed of the episode.
        rewarded: True if the robot was rewarded.
        untouched: Rewards while not both hands touched the object.
        lifted: True if the object was in the hands, off the table, at the end.
        height: Height by which it was lifted, m.
        force: Largest force on a fingertip, in any direction, N.
        seconds: Simulated time.
        ending: Ending of the program.
    """

    seed: int
    rewarded: bool
    untouched: int
    lifted: bool
    height: float
    force: float
    seconds: float
    ending: str


class _Judge:
    """Watches one episode by the simulator's truth, which no controller sees."""

    def __init__(self, truth: Any, thing: str) -> None:
        self._truth, self._thing = truth, thing
        self._hands = {hand for hand, _ in truth.cells}
        self._last_touch = dict.fromkeys(self._hands, -BEFORE - 1)
        self._tick = self.untouched = 0
        self._force = 0.0
        self._start: Floats | None = None

    def note(self, tick: Any) -> None:
        """Take in a tick."""
        self._tick += 1
        if self._start is None:
            self._start = self._truth.pose(self._thing).position
        for hand, _ in self._truth.touching(self._thing):
            self._last_touch[hand] = self._tick
        forces = np.linalg.norm(self._truth.wrenches()[:, :3], axis=1)
        self._force = max(self._force, float(forces.max()))

    def judge_reward(self, transition: Any) -> None:
        """Take in a transition; rewards of programs that it uses are not for the hands."""
        if transition.depth == 0 and "squeeze" in transition.rewarding:
            since = [self._tick + 1 - last for last in self._last_touch.values()]
            self.untouched += max(since) > BEFORE

    def conclude(self, seed: int, result: Any) -> Episode:
        """Return the outcome of an episode."""
        assert self._start is not None
        height = float(self._truth.pose(self._thing).position[2] - self._start[2])
        touching = {hand for hand, _ in self._truth.touching(self._thing)}
        lifted = height > LIFTED and touching == self._hands and not self._is_borne()
        return Episode(
            seed, result.rewarded, self.untouched, lifted, round(height, 3),
            round(self._force, 1), result.sim_seconds, result.ending,
        )  # fmt: skip

    def _is_borne(self) -> bool:
        """Return True if anything but the robot presses on the object."""
        truth = self._truth
        points = pybullet.getContactPoints(truth.bodies[self._thing], physicsClientId=truth.client)
        return any(point[2] != truth.robot.id and point[9] > 0.0 for point in points)


def run_episodes(program: str, cameras: str, thing: str, seeds: Iterable[int]) -> list[Episode]:
    """Take one kind of thing, in this process."""
    from cbdsl.api.run_request import read_request
    from cbdsl.backends.staging.world_state import GroundTruthProvider
    from cbdsl.cli.simulation import simulation
    from cbdsl.runtime.episode import Runner

    request = read_request(program, "large_things", None, {"feature": "red"})
    episodes = []
    with simulation(request, "bullet", cameras=cameras) as (backend, kinematics):
        runner = Runner(request.robot, kinematics, request.program, backend)
        for seed in seeds:
            assert isinstance(backend, GroundTruthProvider)
            judge = _Judge(backend.truth, thing)
            result = runner.run(request.stage, seed, thing, judge.judge_reward, judge.note)
            episodes.append(judge.conclude(seed, result))
    return episodes


def summarise(thing: str, episodes: Sequence[Episode]) -> dict[str, Any]:
    """Return one row of the table."""
    count = len(episodes)
    rewarded = sum(each.rewarded for each in episodes)
    lifted = sum(each.lifted for each in episodes)
    untouched = sum(each.untouched for each in episodes)
    return {
        "thing": thing,
        "episodes": count,
        "rewarded": rewarded,
        "rewarded_interval": _interval(rewarded, count),
        "rewarded_untouched": untouched,
        "lifted": lifted,
        "lifted_interval": _interval(lifted, count),
        "height_m": np.quantile([e.height for e in episodes], [0.0, 0.5, 1.0]).round(3).tolist(),
        "largest_force": max(each.force for each in episodes),
        "sim_seconds": round(sum(each.seconds for each in episodes) / count, 1),
        "amiss": [(e.seed, e.height, e.ending) for e in episodes if not e.lifted],
        "met": rewarded >= REWARDED * count and not untouched,
    }


def _interval(successes: int, count: int) -> list[float]:
    return [round(bound, 3) for bound in exact_interval(successes, count)]


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--episodes", type=int, default=40, help="of each thing")
    parser.add_argument("--seed", type=int, default=20000)
    parser.add_argument("--workers", type=int, default=os.cpu_count() or 1)
    parser.add_argument("--only", choices=THINGS, help="one of the things")
    parser.add_argument("--program", default="take_with_both")
    parser.add_argument("--cameras", default="rendered", choices=["rendered", "ideal"])
    parser.add_argument("--json", action="store_true")
    options = parser.parse_args()
    seeds = range(options.seed, options.seed + options.episodes)
    parts = [seeds[k :: options.workers] for k in range(options.workers)]
    met = True
    with ProcessPoolExecutor(options.workers) as pool:
        for thing in [options.only] if options.only else THINGS:
            settings = [[each] * len(parts) for each in (options.program, options.cameras, thing)]
            done = pool.map(run_episodes, *settings, parts)
            row = summarise(thing, sorted(each for some in done for each in some))
            met = met and row["met"]
            print(json.dumps(row) if options.json else _line(row), flush=True)
    sys.exit(not met)


def _line(row: Mapping[str, Any]) -> str:
    return "  ".join(f"{key} {value}" for key, value in row.items())


if __name__ == "__main__":
    main()
