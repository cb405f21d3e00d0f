"""Which of the source's things stay on each other: ``stack``, judged by the simulator.

The judge is the simulator's truth, which no controller sees. A stack stands where, at least 1 s
after the hand has let go, the thing rests and touches the lower one and nothing else. The pace of
the release is the thing's largest speed within 0.2 s after the last fingertip left it. Shares are
of all episodes, with exact (Clopper-Pearson) 95 % intervals, beside those of Table 7.1. Exits with
1 where flat on flat stays in fewer than 95 %.

    python benchmarks/stacks.py --episodes 40 --seed 8500000 [--only purple_box_on_blue_box]
        [--backend bullet] [--cameras rendered] [--json]
"""

from __future__ import annotations

import argparse
import json
import math
import sys
from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from cbdsl.reproduction.interval import exact_interval

PROGRAM, STAGE = "stack", "stacks"
FLAT, TARGET = "purple_box_on_blue_box", 0.95
STILL, LONG, JUST = 0.01, 1.0, 0.2  # m/s, s, s
TICK = 1 / 60

#: Stacks, and the source's shares (Table 7.1); ``None`` for those that it does not have.
STACKS: Mapping[str, float | None] = {
    "purple_box_on_blue_box": 1.0,
    "basketball_on_blue_box": 0.2,
    "football_on_blue_box": 0.8,
    "basketball_on_purple_box": 0.0,
    "football_on_purple_box": 0.4,
    "basketball_on_football": 0.0,
    "football_on_basketball": 0.0,
    "purple_box_on_basketball": None,
    "purple_box_on_football": None,
}


class Episode(NamedTuple):
    """One thing set on another one.

    Attributes:
        seed: of the episode.
        released: whether it was let go.
        stands: whether it stayed.
        offset: distance on the level between the centres at the release, mm; NaN without.
        pace: of the thing just after the release, mm/s; NaN without.
        seconds: from the release to the end.
        ending: of the program.
    """

    seed: int
    released: bool
    stands: bool
    offset: float
    pace: float
    seconds: float
    ending: str


class _Judge:
    """Watches one episode by the simulator's truth, which no controller sees."""

    def __init__(self, truth: Any) -> None:
        self._truth = truth
        self._left = -1
        self._ticks = 0
        self._offset, self._pace = math.nan, 0.0

    def note(self, tick: Any) -> None:
        """Take in a tick."""
        self._ticks += 1
        action = tick.run.action
        if action is None or action.name not in ("release", "retreat"):
            return
        if self._truth.touched("top"):
            self._left, self._pace = -1, 0.0
            return
        if self._left < 0:
            self._left, self._offset = self._ticks, self._distance()
        if (self._ticks - self._left) * TICK <= JUST:
            speed = float(np.linalg.norm(self._truth.velocity("top")))
            self._pace = max(self._pace, speed)

    def _distance(self) -> float:
        top, base = (self._truth.pose(name).position for name in ("top", "base"))
        return math.dist(top[:2], base[:2])

    def conclude(self, seed: int, ending: str) -> Episode:
        """What became of it."""
        released = self._left >= 0
        seconds = (self._ticks - self._left) * TICK if released else 0.0
        alone = set(self._truth.neighbours("top")) == {"base"} and not self._truth.touched("top")
        rests = float(np.linalg.norm(self._truth.velocity("top"))) < STILL
        stands = released and seconds >= LONG and alone and rests
        return Episode(
            seed, released, stands, round(1e3 * self._offset, 1),
            round(1e3 * self._pace, 1) if released else math.nan, round(seconds, 2), ending,
        )  # fmt: skip


def run_episodes(name: str, seeds: Iterable[int], engine: str, cameras: str) -> Iterator[Episode]:
    """Stack two things."""
    from cbdsl.api.run_request import read_request
    from cbdsl.cli.simulation import simulation
    from cbdsl.runtime.episode import Runner

    request = read_request(PROGRAM, STAGE, None, {})
    with simulation(request, engine, cameras=cameras) as (backend, kinematics):
        runner = Runner(request.robot, kinematics, request.program, backend)
        for seed in seeds:
            judge = _Judge(backend.truth)  # type: ignore[attr-defined]
            result = runner.run(request.stage, seed, name, on_tick=judge.note)
            yield judge.conclude(seed, result.ending)


def summarise(name: str, episodes: Sequence[Episode]) -> dict[str, Any]:
    """One row of the table."""
    stand = sum(each.stands for each in episodes)
    released = [each for each in episodes if each.released]
    return {
        "stack": name,
        "episodes": len(episodes),
        "released": len(released),
        "stands": stand,
        "interval": [round(bound, 3) for bound in exact_interval(stand, len(episodes))],
        "source": STACKS[name],
        "offset_mm": _median([each.offset for each in released]),
        "pace_mm_s": _median([each.pace for each in released]),
        "amiss": [(e.seed, e.offset, e.pace, e.ending[:60]) for e in episodes if not e.stands],
        "met": name != FLAT or stand >= TARGET * len(episodes),
    }


def _median(values: Sequence[float]) -> float | None:
    return round(float(np.median(values)), 1) if values else None


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--episodes", type=int, default=40, help="of each stack")
    parser.add_argument("--seed", type=int, default=8500000)
    parser.add_argument("--only", default=",".join(STACKS), help="some of the stacks")
    parser.add_argument("--backend", default="mujoco", choices=["bullet", "mujoco"])
    parser.add_argument("--cameras", default="ideal", choices=["rendered", "ideal"])
    parser.add_argument("--json", action="store_true")
    options = parser.parse_args()
    seeds = range(options.seed, options.seed + options.episodes)
    rows = []
    for name in options.only.split(","):
        episodes = list(run_episodes(name, seeds, options.backend, options.cameras))
        rows.append(summarise(name, episodes))
        if not options.json:
            print("\n".join(f"{k}: {v}" for k, v in rows[-1].items()), flush=True)
    if options.json:
        print(json.dumps(rows))
    sys.exit(not all(row["met"] for row in rows))


if __name__ == "__main__":
    main()
