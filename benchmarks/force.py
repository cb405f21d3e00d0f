"""How well programs of force and place do, judged by the simulator and not by the robot.

``press_and_slide`` from drawn places into drawn directions: the true force of the fingertips on
the table stays within 0.5 N of 3 N, in means over 0.1 s, while the palm truly slides by 10 cm to
within 5 mm. ``take_and_put_down``: the thing stands within 2 cm of where it was held, at rest and
tilted by less than 10 degrees; contact is false where the thing did not touch the table then.
Rates come with exact (Clopper-Pearson) 95 % intervals; exit 1 where one is below its target.

    python benchmarks/force.py --episodes 40 --seed 5000000 [--only press_and_slide] [--json]
"""

from __future__ import annotations

import argparse
import json
import math
import sys
from collections.abc import Mapping
from typing import Any

import numpy as np
import pybullet  # noqa: TID251 (the judge, not the robot)
from numpy.typing import NDArray

from cbdsl.reproduction.interval import exact_interval
from cbdsl.reproduction.simulation_fixture import SimulationFixture, simulation_fixture
from cbdsl.runtime.episode import EpisodeResult, Tick

Floats = NDArray[np.float64]

FORCE, TOLERANCE, WAY = 3.0, 0.5, 0.10  # N, N, m
WINDOW = 6  # ticks: 0.1 s
TARGETS = {"press_and_slide": 0.95, "take_and_put_down": 0.95}


class Pressing:
    """True forces and places of the palm while the hand slides."""

    def __init__(self, fixture: SimulationFixture) -> None:
        self._truth = fixture.backend.truth
        self.forces: list[float] = []
        self.places: list[Floats] = []

    def note(self, tick: Tick) -> None:
        """Take in a tick of the slide."""
        action = tick.run.action
        if action is not None and action.name.startswith("along"):
            self.forces.append(-float(self._truth.wrenches()[:, 2].sum()))
            self.places.append(self._truth.link_pose("right_palm").position.copy())

    def judge(self, result: EpisodeResult, by: Floats) -> dict[str, Any]:
        """Outcome of an episode whose hand was to slide by so much, m, shape (2,)."""
        if len(self.forces) < WINDOW:
            return {"good": False, "ending": result.ending}
        means = np.convolve(self.forces, np.full(WINDOW, 1 / WINDOW), mode="valid")
        way = (self.places[-1] - self.places[0])[:2]
        worst = float(np.abs(means - FORCE).max())
        missed = float(np.linalg.norm(way - by))
        good = result.outcome == "success" and worst <= TOLERANCE and missed <= 0.005
        return {"good": good, "worst_n": worst, "missed_mm": 1e3 * missed, "ending": result.ending}


class Placing:
    """True poses of the thing: when it is lifted, when contact is reported, and at the end."""

    def __init__(self, fixture: SimulationFixture) -> None:
        self._truth = fixture.backend.truth
        self.before: Any = None
        self.held: Any = None
        self.reported: Any = None

    def _pose(self) -> Any:
        (thing,) = (name for name in self._truth.names() if name != "table")
        return thing, self._truth.pose(thing)

    def note(self, tick: Tick) -> None:
        """Take in a tick."""
        if self.before is None:
            self.before = self._pose()[1]
        child = tick.run.children["put_down"]
        if child.predicate == "X":
            return
        if self.held is None:
            self.held = self._pose()[1]
        place = child.program.members.index("place")
        if self.reported is None and child.state[place] in "01":
            bodies, client = self._truth.bodies, self._truth.client
            thing = bodies[self._pose()[0]]
            points = pybullet.getContactPoints(thing, bodies["table"], physicsClientId=client)
            self.reported = bool(points)

    def judge(self, result: EpisodeResult) -> dict[str, Any]:
        """Outcome of an episode."""
        if self.held is None:
            return {"good": False, "taken": False, "ending": result.ending}
        thing, after = self._pose()
        error = float(np.linalg.norm((after.position - self.held.position)[:2]))
        upright = float(np.clip(after.rotation[:, 2] @ self.before.rotation[:, 2], -1, 1))
        tilt = 0.0 if thing == "ball" else math.degrees(math.acos(upright))
        rests = float(np.linalg.norm(self._truth.velocity(thing)[:3])) < 0.01
        good = result.outcome == "success" and rests and error <= 0.02 and tilt < 10
        return {
            "good": good, "taken": True, "thing": thing, "error_mm": 1e3 * error, "tilt_deg": tilt,
            "rests": rests, "false_contact": self.reported is False, "ending": result.ending,
        }  # fmt: skip


def press(seed: int) -> dict[str, Any]:
    """One episode of ``press_and_slide`` from a drawn place into a drawn direction."""
    rng = np.random.default_rng([seed, 7])
    x, y, angle = rng.uniform(0.40, 0.55), rng.uniform(-0.35, -0.15), rng.uniform(0, 2 * np.pi)
    by = WAY * np.array([np.cos(angle), np.sin(angle)])
    places = {"x": x, "y": y, "by_x": by[0], "by_y": by[1]}
    values = {name: f"{value:.5f} m" for name, value in places.items()}
    with simulation_fixture("press_and_slide", values) as fixture:
        pressing = Pressing(fixture)
        result = fixture.runner().run(fixture.stage, seed, on_tick=pressing.note)
        return {**places, **pressing.judge(result, by)}


def put_down(seed: int) -> dict[str, Any]:
    """One episode of ``take_and_put_down``."""
    with simulation_fixture("take_and_put_down") as fixture:
        placing = Placing(fixture)
        result = fixture.runner().run(fixture.stage, seed, on_tick=placing.note)
        return placing.judge(result)


def summarise(name: str, rows: list[dict[str, Any]]) -> Mapping[str, Any]:
    """Rate and interval of a program's episodes; of what was taken, where it has to be taken."""
    tried = [row for row in rows if row.get("taken", True)]
    good = sum(row["good"] for row in tried)
    rate = good / len(tried) if tried else 0.0
    low, high = exact_interval(good, len(tried)) if tried else (0.0, 1.0)
    false = sum(row.get("false_contact", False) for row in tried)
    is_met = rate >= TARGETS[name] and false == 0
    return {
        "program": name, "episodes": len(rows), "tried": len(tried), "good": good, "rate": rate,
        "interval": [low, high], "target": TARGETS[name], "false_contacts": false, "met": is_met,
    }  # fmt: skip


def main() -> int:
    """Run episodes and print rates; 1 where a target is missed."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--episodes", type=int, default=40, help="of each program")
    parser.add_argument("--seed", type=int, default=5_000_000, help="of the first episode")
    parser.add_argument("--only", choices=sorted(TARGETS), help="one of the programs")
    parser.add_argument("--json", action="store_true", help="print one JSON object a program")
    options = parser.parse_args()
    is_met = True
    for name, run in (("press_and_slide", press), ("take_and_put_down", put_down)):
        if options.only not in (None, name):
            continue
        seeds = range(options.seed, options.seed + options.episodes)
        rows = [{"seed": seed, **run(seed)} for seed in seeds]
        summary = summarise(name, rows)
        is_met &= bool(summary["met"])
        if options.json:
            sys.stdout.write(json.dumps({**summary, "rows": rows}) + "\n")
            continue
        low, high = summary["interval"]
        sys.stdout.write(
            f"{name}: {summary['good']} of {summary['tried']} ({100 * low:.0f} to {100 * high:.0f} "
            f"%), target {100 * summary['target']:.0f} %, false contacts "
            f"{summary['false_contacts']}\n"
        )
        for row in rows:
            if not row["good"]:
                sys.stdout.write(f"  {row}\n")
    return 0 if is_met else 1


if __name__ == "__main__":
    sys.exit(main())
