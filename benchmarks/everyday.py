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
from typing import NamedTuple

import numpy as np
from claims import CLAIMS, Claim, Watch, watched_runner

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


class Stillness:
    """Record of the largest turn of the arms' joints in an episode."""

    def __init__(self) -> None:
        self._first: np.ndarray | None = None
        self.turn = 0.0

    def note(self, tick: object) -> None:
        """Take in a tick."""
        joints = tick.signals.joints  # type: ignore[attr-defined]
        arms = [k for arm in ("left_arm", "right_arm") for k in joints.of(arm)]
        now = tick.observation.positions[arms]  # type: ignore[attr-defined]
        if self._first is None:
            self._first = now.copy()
        self.turn = max(self.turn, float(np.abs(now - self._first).max()))


def run_episodes(
    claim: Claim, contexts: Sequence[str], seeds: Sequence[int], backend: str, cameras: str | None
) -> list[Outcome]:
    """Run the program in some contexts, in this process, and judge the episodes."""
    outcomes = []
    for context in contexts:
        with watched_runner(claim, context, backend, cameras) as (runner, stage, watch_of):
            for seed in seeds:
                watch, still = watch_of(), Stillness()

                def note(tick: object, watch: Watch = watch, still: Stillness = still) -> None:
                    watch.note(tick)
                    still.note(tick)

                result = runner.run(stage, seed, context, on_tick=note)
                kind = "failed"
                if result.outcome == "success":
                    kind = "false" if claim.judge(watch) else "placed"
                elif result.outcome == "failure" and still.turn < STILL:
                    kind = "refused"
                seconds = round(result.sim_seconds, 1)
                outcomes.append(Outcome(context, seed, kind, seconds, result.ending))
    return outcomes


def _run(job: tuple[Claim, Sequence[str], Sequence[int], str, str | None]) -> list[Outcome]:
    claim = CLAIMS[0]._replace(stage=job[0].stage)
    return run_episodes(claim, *job[1:])


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
    from claims import contexts_of

    claim = CLAIMS[0]._replace(stage=options.stage)
    contexts = options.only.split(",") if options.only else list(contexts_of(claim))
    seeds = range(options.seed, options.seed + options.episodes)
    jobs = [(Claim(claim.program, claim.stage, len), [c], seeds, options.backend, options.cameras)
            for c in contexts]
    met = True
    with ProcessPoolExecutor(options.workers) as pool:
        for outcomes in pool.map(_run, jobs):
            met &= _report(outcomes, options.each)
    sys.exit(not met)


def _report(outcomes: Sequence[Outcome], each: bool) -> bool:
    """Print the row of one object; return whether it is handled without false success."""
    for outcome in outcomes if each else ():
        print("   ", *outcome[1:4], outcome.ending, flush=True)
    kinds = Counter(outcome.kind for outcome in outcomes)
    enough = SHARE * len(outcomes)
    handled = max(kinds["placed"], kinds["refused"]) >= enough and not kinds["false"]
    counts = "  ".join(f"{kind} {kinds[kind]:3d}" for kind in ("placed", "refused", "failed", "false"))
    print(f"{outcomes[0].context:16s} {counts}  {'handled' if handled else 'missed'}", flush=True)
    return handled


if __name__ == "__main__":
    main()
