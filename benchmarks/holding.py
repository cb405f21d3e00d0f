"""Success rate of keeping an object in the hand: ``pick_and_lift`` with several forms.

The simulator gives the place of the object in the hand when the grasp closes, before the lift, and
at the end. An object is lost if it is not in the hand at the end. Shares have exact
(Clopper-Pearson) 95 % intervals. The exit status is 1 if a target is missed.

    python benchmarks/holding.py --episodes 40 --seed 5000000 [--only ball,cube] [--left] [--json]
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

THINGS = ("ball", "cube", "cylinder", "light_box")
# Shares of objects that are kept, and that hardly move in the hand.
KEPT, STEADY = 0.97, 0.90
MOST_DRIFT = {"bullet": 8.0, "mujoco": 4.0}  # mm
MOST_TILT, MOST_FORCE = 5.0, 15.0  # deg, N
# Farther from the place of its grasp, m, an object is out of the hand.
_LOST = 0.06


class Setting(NamedTuple):
    """Way to carry objects.

    Attributes:
        program: File or name; its ``arm`` and ``hand`` carry.
        values: Values of the program's parameters.
        backend: Name of the engine.
        cameras: ``rendered`` or ``ideal``.
    """

    program: str
    values: Mapping[str, str]
    backend: str
    cameras: str


class Episode(NamedTuple):
    """Episode with one object, picked and carried.

    Attributes:
        seed: Seed of the episode.
        taken: True if the grip was rewarded.
        kept: True if the program ended with the object in the hand.
        lifted, carried: Displacement upwards and sideways, m.
        drift: Drift of the object in the hand's frame, mm.
        tilt: Tilt of the object's upright axis in the hand's frame, deg.
        force: Largest force on a finger of the hand, in any direction, N.
        seconds: Simulated time.
        ending: Ending of the program.
    """

    seed: int
    taken: bool
    kept: bool
    lifted: float
    carried: float
    drift: float
    tilt: float
    force: float
    seconds: float
    ending: str


def run_episodes(setting: Setting, thing: str, seeds: Iterable[int]) -> list[Episode]:
    """Carry one kind of thing, in this process."""
    from cbdsl.api.run_request import read_request
    from cbdsl.cli.simulation import simulation
    from cbdsl.runtime.episode import Runner

    request = read_request(setting.program, None, None, setting.values)
    with simulation(request, setting.backend, cameras=setting.cameras) as (backend, kinematics):
        runner = Runner(request.robot, kinematics, request.program, backend)
        judge = _Judge(backend, request.robot, setting.values, thing)
        return [judge.watch(runner, request.stage, seed) for seed in seeds]


class _Judge:
    """Measures by the simulator's truth, which no controller sees."""

    def __init__(self, backend: Any, robot: Any, values: Mapping[str, str], thing: str) -> None:
        self._truth, self._thing = backend.truth, thing
        self._palm = robot.effectors[values["arm"]].tip.link
        cells = enumerate(backend.truth.cells)
        self._cells = [index for index, (hand, _) in cells if hand == values["hand"]]

    def watch(self, runner: Any, stage: Any, seed: int) -> Episode:
        """Run one episode."""
        grasps: list[tuple[Floats, Floats, Floats]] = []
        force = 0.0

        def note(transition: Any) -> None:
            if transition.action == "grip" and transition.reward:
                grasps.append((*self._in_hand(), self._truth.pose(self._thing).position))

        def feel(tick: Any) -> None:
            nonlocal force
            own = self._truth.wrenches()[self._cells, :3]
            force = max(force, float(np.linalg.norm(own, axis=1).max()))

        result = runner.run(stage, seed, self._thing, note, feel)
        position, upright = self._in_hand()
        start, up, place = grasps[-1] if grasps else (position, upright, np.full(3, np.nan))
        drift = float(np.linalg.norm(position - start))
        way = self._truth.pose(self._thing).position - place
        return Episode(
            seed,
            bool(grasps),
            bool(grasps) and result.outcome == "success" and drift < _LOST,
            round(float(way[2]), 3),
            round(math.hypot(way[0], way[1]), 3),
            round(1e3 * drift, 1),
            round(math.degrees(math.acos(min(1.0, float(up @ upright)))), 1),
            round(force, 1),
            result.sim_seconds,
            result.ending,
        )

    def _in_hand(self) -> tuple[Floats, Floats]:
        """Return the object's position, m, and upright axis in the hand's frame, each (3,)."""
        palm, thing = self._truth.link_pose(self._palm), self._truth.pose(self._thing)
        return (
            palm.rotation.T @ (thing.position - palm.position),
            palm.rotation.T @ thing.rotation[:, 2],
        )


def summarise(thing: str, episodes: Sequence[Episode], most_drift: float) -> dict[str, Any]:
    """Return one row of the table; objects are steady up to a drift ``most_drift``, mm."""
    kept = [each for each in episodes if each.kept]
    steady = [each for each in kept if each.drift <= most_drift and each.tilt <= MOST_TILT]
    force = max(each.force for each in episodes)
    count = len(episodes)
    return {
        "thing": thing,
        "episodes": count,
        "kept": len(kept),
        "kept_interval": _interval(len(kept), count),
        "steady": len(steady),
        "steady_interval": _interval(len(steady), count),
        "drift_mm": _quantiles([each.drift for each in kept]),
        "tilt_deg": _quantiles([each.tilt for each in kept]),
        "largest_force": force,
        "lifted": _quantiles([each.lifted for each in kept]),
        "carried": _quantiles([each.carried for each in kept]),
        "sim_seconds": round(sum(each.seconds for each in episodes) / count, 1),
        "lost": [(each.seed, each.ending) for each in episodes if not each.kept],
        "met": bool(
            len(kept) >= KEPT * count and len(steady) >= STEADY * count and force <= MOST_FORCE
        ),
    }


def _interval(successes: int, count: int) -> list[float]:
    return [round(bound, 3) for bound in exact_interval(successes, count)]


def _quantiles(values: Sequence[float]) -> list[float]:
    """Return median, nine of ten, largest."""
    if not values:
        return []
    return [round(float(each), 3) for each in np.quantile(values, [0.5, 0.9, 1.0])]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--episodes", type=int, default=40, help="of each thing")
    parser.add_argument("--seed", type=int, default=20000)
    parser.add_argument("--workers", type=int, default=os.cpu_count() or 1)
    parser.add_argument("--only", help="things, separated by commas")
    parser.add_argument("--program", default="pick_and_lift")
    parser.add_argument("--left", action="store_true", help="carry with the left hand")
    parser.add_argument("--backend", default="bullet", choices=["bullet", "mujoco"])
    parser.add_argument("--cameras", default="rendered", choices=["rendered", "ideal"])
    parser.add_argument("--each", action="store_true", help="print every episode")
    parser.add_argument("--json", action="store_true")
    options = parser.parse_args()
    side = "left" if options.left else "right"
    values = {"arm": f"{side}_arm", "hand": f"{side}_hand"}
    setting = Setting(options.program, values, options.backend, options.cameras)
    met = True
    with ProcessPoolExecutor(options.workers) as pool:
        for thing in options.only.split(",") if options.only else THINGS:
            seeds = range(options.seed, options.seed + options.episodes)
            parts = [seeds[k :: options.workers] for k in range(options.workers)]
            done = pool.map(run_episodes, [setting] * len(parts), [thing] * len(parts), parts)
            episodes = sorted(each for some in done for each in some)
            row = summarise(thing, episodes, MOST_DRIFT[options.backend])
            met = met and row["met"]
            for each in episodes if options.each else ():
                print(json.dumps(each._asdict()))
            print(json.dumps(row) if options.json else _line(row), flush=True)
    sys.exit(not met)


def _line(row: Mapping[str, Any]) -> str:
    return (
        f"{row['thing']:<10} kept {row['kept']:>3} of {row['episodes']:<3} {row['kept_interval']}  "
        f"steady {row['steady']:>3} {row['steady_interval']}  drift {row['drift_mm']} mm  "
        f"tilt {row['tilt_deg']} deg  force {row['largest_force']} N  "
        f"lifted {row['lifted']} carried {row['carried']} m  {row['sim_seconds']} s  "
        f"{'met' if row['met'] else 'missed'} {row['lost'][:3] or ''}"
    )


if __name__ == "__main__":
    main()
