"""Everyday objects with ``deliver``: placed, or refused before motion, judged by the simulator.

An object is placed if the program succeeds and the object rests on or beside the pad, after it was
lifted. It is refused before motion if the program fails before an arm moved and a hand touched it.
It is handled if one of both is so in at least 18 of 20 episodes. Exits with 1 where an object is
not handled, or a success is false.

    python benchmarks/everyday.py --episodes 20 --seed 42000000 [--stage everyday_objects]
        [--only die,book] [--backend mujoco] [--cameras ideal] [--each]
"""

from __future__ import annotations

import argparse
import os
import sys
from collections import Counter
from collections.abc import Sequence
from concurrent.futures import ProcessPoolExecutor
from functools import partial
from typing import Any, NamedTuple

import numpy as np
from claim_judges import CLAIMS, Watch
from claims import contexts_of
from numpy.typing import NDArray

CLAIM = next(claim for claim in CLAIMS if claim.program == "deliver")

# Largest turn of an arm's joint without motion, rad, and share of episodes of a handled object.
STILL, SHARE = 0.05, 0.9


class Outcome(NamedTuple):
    """Outcome of an episode.

    Attributes:
        context, seed: Context and seed of the run.
        kind: ``placed``, ``refused``, ``failed`` or ``false``.
        seconds: Simulated time.
        ending: Ending of the program.
    """

    context: str
    seed: int
    kind: str
    seconds: float
    ending: str


class Job(NamedTuple):
    """Episodes of one context.

    Attributes:
        stage, context: Stage and one of its contexts.
        seeds: Seeds of the episodes.
        backend, cameras: Engine and kind of cameras.
    """

    stage: str
    context: str
    seeds: Sequence[int]
    backend: str
    cameras: str


class World:
    """World of a backend's current episode."""

    def __init__(self, body: Any) -> None:
        self._body = body

    def __getattr__(self, name: str) -> Any:
        return getattr(self._body.truth, name)


class Stillness:
    """Record of the largest turn of the arms' joints in an episode."""

    def __init__(self) -> None:
        self._first: NDArray[np.float64] | None = None
        self.turn = 0.0

    def note(self, tick: object) -> None:
        """Take in a tick."""
        joints = tick.signals.joints  # type: ignore[attr-defined]
        arms = [k for arm in ("left_arm", "right_arm") for k in joints.of(arm)]
        now = tick.observation.positions[arms]  # type: ignore[attr-defined]
        if self._first is None:
            self._first = now.copy()
        self.turn = max(self.turn, float(np.abs(now - self._first).max()))


def run_episodes(job: Job) -> list[Outcome]:
    """Run the program in one context, in this process, and judge the episodes."""
    from cbdsl.api.run_request import read_request
    from cbdsl.backends.staging.world_state import GroundTruthProvider
    from cbdsl.cli.simulation import simulation
    from cbdsl.runtime.episode import Runner

    request = read_request(CLAIM.program, job.stage, None, {})
    outcomes = []
    with simulation(request, job.backend, cameras=job.cameras) as (body, kinematics):
        assert isinstance(body, GroundTruthProvider)
        runner = Runner(request.robot, kinematics, request.program, body)
        things = [*(request.stage.contexts[job.context].placed or ()), *request.stage.things]
        for seed in job.seeds:
            watch, still = Watch(World(body), things), Stillness()
            result = runner.run(
                request.stage, seed, job.context, on_tick=partial(_note, (watch, still))
            )
            kind = "failed"
            if result.outcome == "success":
                kind = "false" if CLAIM.judge(watch) else "placed"
            elif result.outcome == "failure" and still.turn < STILL:
                kind = "refused"
            seconds = round(result.sim_seconds, 1)
            outcomes.append(Outcome(job.context, seed, kind, seconds, result.ending))
    return outcomes


def _note(listeners: Sequence[Any], tick: object) -> None:
    for listener in listeners:
        listener.note(tick)


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--episodes", type=int, default=20, help="of each object")
    parser.add_argument("--seed", type=int, default=20000)
    parser.add_argument("--stage", default="everyday_objects")
    parser.add_argument("--only", help="some of the objects")
    parser.add_argument("--backend", default="mujoco", choices=["bullet", "mujoco"])
    parser.add_argument("--cameras", default="ideal", choices=["rendered", "ideal"])
    parser.add_argument("--workers", type=int, default=os.cpu_count() or 1)
    parser.add_argument("--each", action="store_true", help="print every episode")
    options = parser.parse_args()
    contexts = contexts_of(CLAIM._replace(stage=options.stage))
    if options.only:
        contexts = options.only.split(",")
    seeds = range(options.seed, options.seed + options.episodes)
    jobs = [Job(options.stage, c, seeds, options.backend, options.cameras) for c in contexts]
    met = True
    with ProcessPoolExecutor(options.workers) as pool:
        for outcomes in pool.map(run_episodes, jobs):
            met &= _report(outcomes, each=options.each)
    sys.exit(not met)


def _report(outcomes: Sequence[Outcome], *, each: bool) -> bool:
    """Print the row of one object; return whether it is handled without false success."""
    for outcome in outcomes if each else ():
        print("   ", *outcome[1:4], outcome.ending, flush=True)
    kinds = Counter(outcome.kind for outcome in outcomes)
    enough = SHARE * len(outcomes)
    handled = max(kinds["placed"], kinds["refused"]) >= enough and not kinds["false"]
    counts = "  ".join(
        f"{kind} {kinds[kind]:3d}" for kind in ("placed", "refused", "failed", "false")
    )
    print(f"{outcomes[0].context:16s} {counts}  {'handled' if handled else 'missed'}", flush=True)
    return handled


if __name__ == "__main__":
    main()
