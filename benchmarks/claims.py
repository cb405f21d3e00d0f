"""Claims of success of programs, judged by the simulator's truth.

A program claims success by its ``success``, or by its reward if it states none. The claim is false
if the world contradicts it. An object to be placed must have been lifted, and be at rest on its
goal and out of the hand. An upper object must stand on the lower one alone. An object to be lifted
or touched must be lifted or touched. A missing claim is not a fault here. Shares have exact
(Clopper-Pearson) 95 % intervals. The exit status is 1 if any claim is false.

    python benchmarks/claims.py --episodes 4 --seed 40000000 [--only deliver,stand]
        [--backend mujoco] [--cameras ideal] [--each] [--json]
"""

from __future__ import annotations

import argparse
import json
import math
import os
import sys
from collections.abc import Callable, Iterable, Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from cbdsl.numeric.proportion import exact_interval

Floats = NDArray[np.float64]

# An object is lifted, near its goal, at rest and raised from here on, m and m/s.
LIFTED, NEAR, STILL, RAISED = 0.02, 0.06, 0.01, 0.05
# Ticks of 1/60 s over which a speed is averaged, and before a claim in which a contact counts.
WHILE, BEFORE = 12, 6


class Watch:
    """Truth about the objects of one episode.

    Args:
        truth: Ground truth of the world.
        things: Names of the objects that the stage has.
    """

    def __init__(self, truth: Any, things: Iterable[str]) -> None:
        self._truth, self._all = truth, set(things)
        self._tracks: dict[str, list[Floats]] = {}
        self._alone: dict[str, int] = {}

    def note(self, _: object) -> None:
        """Take in a tick."""
        for name in self._all.intersection(self._truth.names()):
            self._tracks.setdefault(name, []).append(self._truth.pose(name).position.copy())
            borne = bool(self._truth.neighbours(name))
            self._alone[name] = 0 if borne else self._alone.get(name, 0) + 1

    @property
    def things(self) -> list[str]:
        """Names of the objects that are in the world."""
        return list(self._tracks)

    def lift(self, name: str) -> float:
        """Return the largest height of an object above its first place, m."""
        track = np.array(self._tracks[name])
        return float((track[:, 2] - track[0, 2]).max())

    def height(self, name: str) -> float:
        """Return the height of an object above its first place at the end, m."""
        track = self._tracks[name]
        return float(track[-1][2] - track[0][2])

    def level(self, name: str) -> float:
        """Return the height of an object in the world at the end, m."""
        return float(self._tracks[name][-1][2])

    def speed(self, name: str) -> float:
        """Return the mean speed of an object over the last ticks, m/s."""
        track = self._tracks[name][-WHILE:]
        return 60.0 * math.dist(track[0], track[-1]) / max(len(track) - 1, 1)

    def distance(self, name: str, goal: str) -> float:
        """Return the distance of an object from a goal on the level, m."""
        place = self._truth.pose(goal).position
        return math.dist(self._tracks[name][-1][:2], place[:2])

    def is_held(self, name: str) -> bool:
        """Return whether the robot touches an object."""
        return bool(self._truth.touched(name))

    def is_borne(self, name: str) -> bool:
        """Return whether another object bore an object a moment ago."""
        return self._alone[name] <= BEFORE

    def neighbours(self, name: str) -> set[str]:
        """Return the names of the objects that press on an object."""
        return set(self._truth.neighbours(name))


def _placed(watch: Watch) -> str:
    """Judge that the object hangs on nothing, near the pad, after it was lifted."""
    (name,) = watch.things
    off = watch.distance(name, "pad")
    if watch.lift(name) < LIFTED:
        return f"lifted by {1e3 * watch.lift(name):.0f} mm"
    if off > NEAR:
        return f"{1e3 * off:.0f} mm off the pad"
    return "" if watch.is_borne(name) else "in the air"


def _delivered(watch: Watch) -> str:
    """Judge that the object was placed, released, and rests."""
    (name,) = watch.things
    if watch.is_held(name):
        return "still in the hand"
    if watch.speed(name) > STILL:
        return f"moving at {1e3 * watch.speed(name):.0f} mm/s"
    return _placed(watch)


def _put_down(watch: Watch) -> str:
    """Judge that the object was lifted, released, and rests on something."""
    (name,) = watch.things
    if watch.is_held(name):
        return "still in the hand"
    if watch.lift(name) < LIFTED:
        return f"lifted by {1e3 * watch.lift(name):.0f} mm"
    if watch.speed(name) > STILL:
        return f"moving at {1e3 * watch.speed(name):.0f} mm/s"
    return "" if watch.is_borne(name) else "in the air"


def _stands(watch: Watch) -> str:
    """Judge that each object rests on the one below it and on nothing else."""
    heights = sorted(watch.things, key=watch.level)
    for below, name in pairwise(heights):
        if watch.speed(name) > STILL:
            return f"{name} moves at {1e3 * watch.speed(name):.0f} mm/s"
        if below not in watch.neighbours(name) or "table" in watch.neighbours(name):
            return f"{name} is beside {below}"
    return ""


def _set_on(watch: Watch) -> str:
    """Judge that the lower object bears the upper one."""
    if (
        watch.is_borne("top")
        and watch.lift("top") >= LIFTED
        and watch.distance("top", "base") < NEAR
    ):
        return ""
    return f"{1e3 * watch.distance('top', 'base'):.0f} mm off the lower object"


def _raised(watch: Watch) -> str:
    """Judge that the object is in a hand, and off the table."""
    (name,) = watch.things
    if not watch.is_held(name):
        return "not in the hand"
    height = watch.height(name)
    return "" if height > RAISED else f"raised by {1e3 * height:.0f} mm"


def _touched(watch: Watch) -> str:
    """Judge that the robot touches an object of the stage."""
    return "" if any(map(watch.is_held, watch.things)) else "touches no object"


class Claim(NamedTuple):
    """Program on a stage, and the judge of its claims.

    Attributes:
        program, stage: Names of the documents.
        judge: Function that returns why a claim is false, empty if it is true.
        contexts: Contexts of the stage; all if empty.
        values: Values of the program's parameters, by context.
    """

    program: str
    stage: str
    judge: Callable[[Watch], str]
    contexts: tuple[str, ...] = ()
    values: Callable[[str], Mapping[str, str]] = lambda context: {}


_CHANNELS = {"blue_box": "blue", "purple_box": "hue_9", "basketball": "red", "football": "green"}


def _pair(context: str) -> Mapping[str, str]:
    """Return channels of two objects of the stage ``stacking``."""
    upper, _, lower = context.partition("_on_")
    return {"feature": _CHANNELS[upper], "goal": _CHANNELS[lower]}


_PAIRS = tuple(f"{a}_on_{b}" for a in _CHANNELS for b in _CHANNELS if a != b)
_SET = tuple(f"{name}" for name in ("can_on_slab", "box_on_drum", "ball_on_drum", "can_on_ball"))

#: Claims of the shipped programs about objects that none of them was trained with.
CLAIMS = (
    Claim("deliver", "everyday_objects", _delivered),
    Claim("pick_and_place", "everyday_objects", _placed),
    Claim("pick_and_lift", "everyday_objects", _raised),
    Claim("take_and_put_down", "everyday_objects", _put_down, values=lambda _: {"feature": "red"}),
    Claim("stand", "stacking", _stands, _PAIRS, _pair),
    Claim("stack", "stacking", _stands, _PAIRS, _pair),
    Claim("set_on", "other_pairs", _set_on, _SET),
    Claim("find_by_touch", "lights_out", _touched, ("dark",)),
)


class Episode(NamedTuple):
    """Episode with one claim, or none.

    Attributes:
        program, context, seed: Program, context and seed of the run.
        claimed: True if the program reports success.
        fault: Reason why that is false; empty if it is true, or nothing is claimed.
        seconds: Simulated time.
        ending: Ending of the program.
    """

    program: str
    context: str
    seed: int
    claimed: bool
    fault: str
    seconds: float
    ending: str


def run_episodes(
    claim: Claim, contexts: Sequence[str], seeds: Sequence[int], backend: str, cameras: str | None
) -> list[Episode]:
    """Run a program in some contexts, in this process, and judge its claims."""
    from cbdsl.api.run_request import read_request
    from cbdsl.backends.staging.world_state import GroundTruthProvider
    from cbdsl.cli.simulation import simulation
    from cbdsl.runtime.episode import Runner

    episodes = []
    for context in contexts:
        request = read_request(claim.program, claim.stage, None, dict(claim.values(context)))
        with simulation(request, backend, cameras=cameras) as (body, kinematics):
            assert isinstance(body, GroundTruthProvider)
            runner = Runner(request.robot, kinematics, request.program, body)
            things = _names(request.stage, context)
            for seed in seeds:
                watch = Watch(_Truth(body), things)
                result = runner.run(request.stage, seed, context, on_tick=watch.note)
                claimed = (
                    result.outcome == "success" if request.program.success else result.rewarded
                )
                fault = claim.judge(watch) if claimed else ""
                seconds, ending = result.sim_seconds, result.ending
                episodes.append(
                    Episode(claim.program, context, seed, claimed, fault, seconds, ending)
                )
    return episodes


class _Truth:
    """The world of a backend's current episode."""

    def __init__(self, body: Any) -> None:
        self._body = body

    def __getattr__(self, name: str) -> Any:
        return getattr(self._body.truth, name)


def _names(stage: Any, context: str) -> list[str]:
    """Return the names by which a context's objects are in the world."""
    shown = stage.contexts[context]
    return [*(shown.placed or ()), *stage.things]


def contexts_of(claim: Claim) -> Sequence[str]:
    """Return contexts in which a claim is judged."""
    from cbdsl.api.run_request import read_request

    return claim.contexts or list(read_request(claim.program, claim.stage, None, {}).stage.contexts)


def summarise(claim: Claim, episodes: Sequence[Episode]) -> dict[str, Any]:
    """Return one row of the table."""
    false = [each for each in episodes if each.fault]
    claimed = sum(each.claimed for each in episodes)
    low, high = exact_interval(len(false), len(episodes))
    return {
        "program": claim.program,
        "stage": claim.stage,
        "episodes": len(episodes),
        "claimed": claimed,
        "false": len(false),
        "interval": [round(low, 4), round(high, 4)],
        "faults": [(each.context, each.seed, each.fault) for each in false],
        "met": not false,
    }


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--episodes", type=int, default=4, help="of each context")
    parser.add_argument("--seed", type=int, default=20000)
    parser.add_argument("--only", default=",".join(each.program for each in CLAIMS))
    parser.add_argument("--backend", default="mujoco", choices=["bullet", "mujoco"])
    parser.add_argument("--cameras", default="ideal", choices=["rendered", "ideal"])
    parser.add_argument("--workers", type=int, default=os.cpu_count() or 1)
    parser.add_argument("--each", action="store_true", help="print every episode")
    parser.add_argument("--json", action="store_true")
    options = parser.parse_args()
    seeds, workers = range(options.seed, options.seed + options.episodes), options.workers
    rows = []
    for claim in (each for each in CLAIMS if each.program in options.only.split(",")):
        contexts = contexts_of(claim)
        jobs = [
            (claim.program, contexts[k::workers], seeds, options.backend, options.cameras)
            for k in range(workers)
        ]
        with ProcessPoolExecutor(workers) as pool:
            done = [e for some in pool.map(_run, jobs) for e in some]
        for each in done if options.each else ():
            print(json.dumps(each._asdict()), flush=True)
        rows.append(summarise(claim, done))
        if not options.json:
            print("  ".join(f"{key} {value}" for key, value in rows[-1].items()), flush=True)
    if options.json:
        print(json.dumps(rows))
    sys.exit(not all(row["met"] for row in rows))


def _run(job: tuple[Any, ...]) -> list[Episode]:
    name = job[0]
    claim = next(each for each in CLAIMS if each.program == name)
    return run_episodes(claim, *job[1:])


if __name__ == "__main__":
    main()
