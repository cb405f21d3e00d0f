"""Claims of success of programs, judged by the simulator's truth.

A program claims success if it ends as achieved: by its ``success`` if it states one, otherwise by
its reward, or as done. The claim is false if the world contradicts it; ``claim_judges.py`` has the
judges. A missing claim is not a fault here. Shares have exact (Clopper-Pearson) 95 % intervals. The
exit status is 1 if any claim is false.

    python benchmarks/claims.py --episodes 4 --seed 40000000 [--only deliver,stand]
        [--backend mujoco] [--cameras ideal] [--each] [--json]
"""

from __future__ import annotations

import argparse
import json
import os
import sys
from collections.abc import Sequence
from concurrent.futures import ProcessPoolExecutor
from typing import Any, NamedTuple

from claim_judges import CLAIMS, Claim, Watch

from cbdsl.numeric.proportion import exact_interval


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
                claimed = runner.predicate == "1"
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
