"""Curves of rewards of two arms: learned from scratch, and with the policy of one arm.

From scratch, two Pandas first learn a policy with one arm in the middle of a bench (ACCOMMODATE).
They then learn the allocation of arms on the whole bench (ASSIMILATE, Section 5.4). By transfer,
they keep the policy of a single Panda, the best of three by its last ten episodes. They learn the
allocation from the first episode on. Each row is the reward per state transition (Figure 5.8),
which counts detours, too. The last rows are sums over all episodes.

    python benchmarks/transfer_curves.py [--trials 3] [--episodes 40] [--policy 25]
"""

from __future__ import annotations

import argparse
import os
import shutil
from collections.abc import Iterable
from itertools import chain
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import NamedTuple

from two_pandas import write_two_pandas

import cbdsl

HERE = Path(__file__).parent


class Episode(NamedTuple):
    """Reward and number of state transitions of an episode."""

    reward: int
    transitions: int


def scratch(seed: int, policy: int, episodes: int) -> list[Episode]:
    """Return the rewards of two arms that learn a policy first.

    Args:
        seed: Seed of all draws.
        policy: Number of episodes in which the policy is learned.
        episodes: Number of all episodes.
    """
    first = learn(f"scratch_{seed}", "two_pandas", "middle_of_bench", policy, seed)
    rest = episodes - policy
    then = learn(
        f"staged_{seed}", "two_pandas", "whole_bench", rest, seed, f"scratch_{seed}", "assimilate"
    )
    return first + then


def best_of_one_arm() -> str:
    """Return the name of the best of three policies of a single Panda."""
    policies = {
        f"one_{seed}": per_transition(
            learn(f"one_{seed}", "panda", "middle_of_bench", 40, seed)[-10:]
        )
        for seed in range(3)
    }
    return max(policies, key=lambda name: policies[name])


def learn(
    name: str, robot: str, stage: str, episodes: int, seed: int,
    source: str | None = None, learner: str | None = None,
) -> list[Episode]:  # fmt: skip
    """Return the rewards of episodes, whose knowledge is written to the working folder."""
    outcome = cbdsl.learn(
        cbdsl.load("close_on", stage=stage, values={"robot": robot}), f"{name}.yaml", seed=seed,
        episodes=episodes, backend="kinematic", policy=source, learner=learner,
    )  # fmt: skip
    return [
        Episode(sum(each.reward for each in one.transitions), len(one.transitions))
        for one in outcome.episodes
    ]


def per_transition(episodes: Iterable[Episode]) -> float:
    """Return the reward per state transition."""
    every = [*episodes]
    return sum(each.reward for each in every) / sum(each.transitions for each in every)


def main() -> None:
    """Print both curves, and the rewarded episodes and means of each trial."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--trials", type=int, default=3)
    parser.add_argument("--episodes", type=int, default=40)
    parser.add_argument("--policy", type=int, default=25)
    options = parser.parse_args()
    with TemporaryDirectory() as folder:
        shutil.copytree(HERE / "transfer" / "programs", Path(folder, "programs"))
        write_two_pandas(HERE.parent / "robots", Path(folder, "robots"))
        os.chdir(folder)
        seeds, policy = range(1, options.trials + 1), best_of_one_arm()
        curves = {
            "scratch": [scratch(seed, options.policy, options.episodes) for seed in seeds],
            "transfer": [
                learn(f"two_{n}", "two_pandas", "whole_bench", options.episodes, n, policy)
                for n in seeds
            ],
        }
    print("episodes", *(f"{name:>12}" for name in curves))
    for first in range(0, options.episodes, 5):
        rows = [[each[first : first + 5] for each in trials] for trials in curves.values()]
        shares = [per_transition(chain(*row)) for row in rows]
        print(f"{first + 1:3} to {first + 5:2}", *(f"{share:12.3f}" for share in shares))
    for name, trials in curves.items():
        sums = [sum(each.reward for each in one) for one in trials]
        means = ", ".join(f"{per_transition(one):.3f}" for one in trials)
        print(f"{name}: {sum(sums)} of {sum(map(len, trials))} rewarded; trials {means}")


if __name__ == "__main__":
    main()
