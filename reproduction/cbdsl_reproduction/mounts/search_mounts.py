"""Search for mounts of Dexter's arms with which manipulability joins the hands (Eq 4.15).

For each mount, Dexter's model is written with the arms there, and moved by the control law on its
kinematics. The right hand grasps an object at twelve places of the right half of the table, and
both arms ascend their manipulability until it rests. Mounts are first spread over the bounds, then
drawn near the best ones. Rows are appended to a file, so that a search can continue.

    python -m cbdsl_reproduction.mounts.search_mounts build/mounts.jsonl --spread 400 --trials 1000

With ``--judge`` the mounts of some rows are tried again: objects are grasped at ``--grasps`` random
places, and both hands reach for as many on either half of the table.
"""

from __future__ import annotations

import argparse
import json
import math
import sys
from collections.abc import Iterator, Sequence
from dataclasses import astuple
from pathlib import Path
from time import perf_counter

import numpy as np

from cbdsl.api.shipped import shipped_robot
from cbdsl_reproduction.mounts.arm_mount import TODAY, ArmMount, near, spread_over
from cbdsl_reproduction.mounts.mount_trial import MountTrial, anywhere, judge
from cbdsl_reproduction.mounts.mounted_arms import JACOBIANS
from cbdsl_reproduction.trial_record import plain_data, read_record

# Number of best mounts used as parents, and spread of their children, of the bounds.
_PARENTS, _WIDTHS = 12, (0.12, 0.01)


def search(
    file: Path, jacobian: str, spread: int, trials: int, seed: int, seconds: float
) -> list[MountTrial]:
    """Continue a search; the first row is today's mount.

    Args:
        file: File of the rows, which may not exist.
        jacobian: One of ``JACOBIANS``.
        spread: Number of mounts all over the bounds.
        trials: Number of all mounts, without today's.
        seed: Seed of the mounts.
        seconds: Time after which no other mount is begun.
    """
    robot, _ = shipped_robot("dexter")
    done = read(file) if file.exists() else []
    begun = perf_counter()
    file.parent.mkdir(parents=True, exist_ok=True)
    with file.open("a", encoding="utf-8") as rows:
        for number in range(len(done), trials + 1):
            if perf_counter() - begun > seconds:
                break
            mount = _draw(number, done, spread, trials, seed)
            trial = judge(number, mount, jacobian, robot)
            done.append(trial)
            print(json.dumps(plain_data(trial)), file=rows, flush=True)
    return done


def judge_again(
    done: Sequence[MountTrial], numbers: Sequence[int], grasps: int, seed: int
) -> Iterator[MountTrial]:
    """Yield mounts of some rows, judged at places that no search has seen."""
    robot, _ = shipped_robot("dexter")
    for number in numbers:
        row = next(trial for trial in done if trial.number == number)
        mount = TODAY if number == 0 else ArmMount(**row.mount)
        rng = np.random.default_rng(seed)
        taken = anywhere(grasps, (-0.40, -0.02), rng)
        places = anywhere(2 * grasps, (-0.40, 0.40), rng)
        yield judge(number, mount, row.jacobian, robot, taken, places, ("left", "right"))


def read(file: Path) -> list[MountTrial]:
    """Return the rows of a file."""
    rows = file.read_text(encoding="utf-8").splitlines()
    return [read_record(MountTrial, json.loads(row)) for row in rows]


def best_of(done: Sequence[MountTrial], count: int) -> list[MountTrial]:
    """Return the best mounts after today's mount, which is the first."""
    return sorted(done[1:], key=lambda trial: -trial.score(done[0]))[:count]


def _draw(number: int, done: Sequence[MountTrial], spread: int, trials: int, seed: int) -> ArmMount:
    """Return today's mount, then mounts all over the bounds, then some near the best so far."""
    if number == 0:
        return TODAY
    if number <= spread:
        return spread_over(spread, np.random.default_rng(seed))[number - 1]
    best = best_of(done, _PARENTS)
    # Without mounts all over the bounds, the first one is near today's.
    parent = ArmMount(**best[number % len(best)].mount) if best else TODAY
    # The spread shrinks geometrically with the number of mounts, from a wide search to a local one.
    # Generators depend on seed and number alone, so that a continued search draws the same mounts.
    wide, narrow = _WIDTHS
    part = (number - spread) / max(1, trials - spread)
    width = wide * (narrow / wide) ** part
    return near(parent, width, np.random.default_rng((seed, number)))


def lines(shown: Sequence[MountTrial], today: MountTrial) -> Iterator[str]:
    """Yield lines about trials, for people."""
    yield (
        "number  score  grasps  near  together  apart, m  aim, m  reach  view  seen  phi   "
        "forward half up swing lift roll elbow rest"
    )
    for trial in shown:
        mount = " ".join(f"{value:.2f}" for value in astuple(ArmMount(**trial.mount)))
        yield (
            f"{trial.number:>6} {trial.score(today):6.3f} {len(trial.apart):>6} "
            f"{trial.near:6.2f} {trial.together:8.2f} {trial.distance:9.2f} {trial.aim:8.2f} "
            f"{trial.reach:6.2f} {trial.view:5.2f} {trial.in_view:5.2f} {trial.phi:5.2f}  {mount}"
        )


def main() -> None:
    """Search."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("file", type=Path, help="of the rows")
    parser.add_argument("--jacobian", choices=JACOBIANS, default="position")
    parser.add_argument("--spread", type=int, default=600, help="mounts all over the bounds")
    parser.add_argument("--trials", type=int, default=1200, help="mounts in all")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--seconds", type=float, default=math.inf, help="no mount is begun later")
    parser.add_argument("--best", type=int, default=10, help="how many are printed")
    parser.add_argument("--judge", type=int, nargs="+", metavar="NUMBER", help="no search: rows")
    parser.add_argument("--grasps", type=int, default=40, help="with --judge")
    options = parser.parse_args()
    if options.judge:
        done = read(options.file)
        judged = judge_again(done, options.judge, options.grasps, options.seed)
        sys.stdout.write("\n".join([*lines(list(judged), done[0]), ""]))
        return
    done = search(
        options.file, options.jacobian, options.spread, options.trials, options.seed,
        options.seconds,
    )  # fmt: skip
    shown = [done[0], *best_of(done, options.best)]
    sys.stdout.write("\n".join([*lines(shown, done[0]), ""]))


if __name__ == "__main__":
    main()
