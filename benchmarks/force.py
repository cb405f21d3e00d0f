"""Force error of ``press_and_slide``, judged by the simulator.

The hand slides by 10 cm from random places into random directions. A slide succeeds if the palm
arrives within 5 mm and the true force of the fingertips on the table stays within 0.5 N of 3 N. The
force is averaged over all physics steps of 0.1 s. The share has an exact (Clopper-Pearson) 95 %
interval. The exit status is 1 if it is below its target.

    python benchmarks/force.py --episodes 40 --seed 5000000 [--left] [--json]
"""

from __future__ import annotations

import argparse
import json
import math
import os
import sys
from collections.abc import Iterable, Sequence
from concurrent.futures import ProcessPoolExecutor
from typing import Any, NamedTuple

import numpy as np

from cbdsl.numeric.arrays import Floats
from cbdsl.numeric.proportion import exact_interval
from cbdsl.runtime.episode_observer import EpisodeListeners

TARGET = 0.95
FORCE, TOLERANCE, WAY, CLOSE = 3.0, 0.5, 0.10, 0.005  # N, N, m, m
WINDOW = 0.1  # s


class Episode(NamedTuple):
    """Episode with one slide.

    Attributes:
        seed: Seed of the episode.
        good: True if force and way are within their tolerances.
        strayed: Largest deviation of the mean force from its reference, N.
        missed: Distance of the palm from its goal, mm.
        ending: Ending of the program.
    """

    seed: int
    good: bool
    strayed: float
    missed: float
    ending: str


class _Judge:
    """Measures by the simulator's truth: the force in every physics step, not in every tick.

    Fingertips that rub lose contact for single steps, which ticks alone would count as too many or
    too few.
    """

    def __init__(self, truth: Any, arm: str, hand: str) -> None:
        self._truth, self._arm = truth, arm
        self._cells = [place for place, (owner, _) in enumerate(truth.cells) if owner == hand]
        self._step, truth.step = truth.step, self._sample
        self.begin()

    def begin(self) -> None:
        """Forget the previous episode."""
        self._sliding = False
        self.forces: list[float] = []
        self.places: list[Floats] = []

    def _sample(self, targets: Floats) -> None:
        self._step(targets)
        if self._sliding:
            self.forces.append(-float(self._truth.wrenches()[self._cells, 2].sum()))

    def note(self, tick: Any) -> None:
        """Take in a tick."""
        action = tick.run.action
        self._sliding = action is not None and action.name.startswith("along")
        if self._sliding:
            self.places.append(self._truth.link_pose(self._arm).position.copy())

    def conclude(self, seed: int, result: Any, by: Floats, window: int) -> Episode:
        """Return the outcome of a hand that should slide by a displacement, m, shape (2,)."""
        if len(self.forces) < window:
            return Episode(seed, False, math.nan, math.nan, result.ending)
        means = np.convolve(self.forces, np.full(window, 1 / window), mode="valid")
        strayed = float(np.abs(means - FORCE).max())
        missed = float(np.linalg.norm((self.places[-1] - self.places[0])[:2] - by))
        good = result.outcome == "success" and strayed <= TOLERANCE and missed <= CLOSE
        return Episode(seed, good, round(strayed, 2), round(1e3 * missed, 1), result.ending)


def run_episodes(backend: str, side: str, seeds: Iterable[int]) -> list[Episode]:
    """Run some slides, in this process, with ideal cameras, because the program uses no vision."""
    from cbdsl.api.run_request import read_request
    from cbdsl.backends.staging.world_state import GroundTruthProvider
    from cbdsl.cli.simulation import simulation
    from cbdsl.runtime.episode import Runner

    episodes = []
    for seed in seeds:
        values, by = _draw(seed, side)
        request = read_request("press_and_slide", None, None, values)
        with simulation(request, backend, cameras="ideal") as (body, kinematics):
            assert isinstance(body, GroundTruthProvider)
            tip = request.robot.effectors[values["arm"]].tip
            assert tip is not None
            judge = _Judge(body.truth, tip.link, values["hand"])
            runner = Runner(request.robot, kinematics, request.program, body)
            result = runner.run(request.stage, seed, observer=EpisodeListeners(on_tick=judge.note))
            window = round(WINDOW * request.robot.simulation.physics_rate)
            episodes.append(judge.conclude(seed, result, by, window))
    return episodes


def _draw(seed: int, side: str) -> tuple[dict[str, str], Floats]:
    """Return the parameters of a slide, and its displacement, m, shape (2,)."""
    rng = np.random.default_rng([seed, 7])
    x, y, angle = rng.uniform(0.40, 0.55), rng.uniform(-0.35, -0.15), rng.uniform(0, 2 * np.pi)
    by = WAY * np.array([np.cos(angle), np.sin(angle)])
    lengths = {"x": x, "y": y if side == "right" else -y, "by_x": by[0], "by_y": by[1]}
    values = {name: f"{value:.5f} m" for name, value in lengths.items()}
    return {**values, "arm": f"{side}_arm", "hand": f"{side}_hand"}, by


def summarise(episodes: Sequence[Episode]) -> dict[str, Any]:
    """Return the result."""
    good = sum(each.good for each in episodes)
    low, high = exact_interval(good, len(episodes))
    strayed = [each.strayed for each in episodes if not math.isnan(each.strayed)]
    return {
        "episodes": len(episodes),
        "good": good,
        "interval": [round(low, 3), round(high, 3)],
        "strayed_n": np.quantile(strayed, [0.5, 0.9, 1.0]).round(2).tolist() if strayed else [],
        "missed_mm": max(each.missed for each in episodes),
        "amiss": [(e.seed, e.strayed, e.missed, e.ending) for e in episodes if not e.good],
        "met": good >= TARGET * len(episodes),
    }


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--episodes", type=int, default=40)
    parser.add_argument("--seed", type=int, default=20000, help="of the first episode")
    parser.add_argument("--workers", type=int, default=os.cpu_count() or 1)
    parser.add_argument("--backend", default="bullet", choices=["bullet", "mujoco"])
    parser.add_argument("--left", action="store_true", help="with the left hand")
    parser.add_argument("--json", action="store_true")
    options = parser.parse_args()
    seeds = range(options.seed, options.seed + options.episodes)
    parts = [seeds[k :: options.workers] for k in range(options.workers)]
    settings = [options.backend] * len(parts), ["left" if options.left else "right"] * len(parts)
    with ProcessPoolExecutor(options.workers) as pool:
        done = pool.map(run_episodes, *settings, parts)
        row = summarise(sorted(each for some in done for each in some))
    print(json.dumps(row) if options.json else "\n".join(f"{k}: {v}" for k, v in row.items()))
    sys.exit(not row["met"])


if __name__ == "__main__":
    main()
