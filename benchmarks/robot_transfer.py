"""Episodes until a skill is learned: from scratch, and with the policy that Dexter learned.

A skill is learned at the first of five successive episodes of which four are rewarded, each within
the number of transitions of its row. Programs that use no seen position have no allocation to
learn, so that the policy runs as it is. The models of the other arms come from ``pybullet_data``
and ``example-robot-data`` (``pip install --no-deps example-robot-data``).

    python benchmarks/robot_transfer.py [--trials 10] [--episodes 20] [--only panda]
"""

from __future__ import annotations

import argparse
import os
import shutil
from collections.abc import Iterator, Sequence
from pathlib import Path
from statistics import median
from tempfile import TemporaryDirectory
from typing import NamedTuple

from public_models import folder_of

import cbdsl

HERE = Path(__file__).parent


class Arm(NamedTuple):
    """Package and file of a model, None for a shipped robot; names of its arm and hand."""

    package: str | None
    file: str
    arm: str
    hand: str


ARMS = {
    "panda": Arm(None, "", "arm", "hand"),
    "xarm6": Arm("pybullet_data", "xarm/xarm6_with_gripper.urdf", "arm", "hand"),
    "baxter": Arm(
        "example-robot-data", "baxter_description/urdf/baxter.urdf", "right_arm", "right_hand"
    ),
}
# Window of episodes, and how many of them are rewarded.
WINDOW, MOST = 5, 4


class Skill(NamedTuple):
    """Program, stage of a gripper, policy that ships, and most transitions of a good episode."""

    program: str
    stage: str
    shipped: str | None
    transitions: int


SKILLS = (
    Skill("tactileprobe", "between_pads_{}", "tactileprobe", 40),
    Skill("reachtouch", "cube_on_bench", "reachtouch", 10),
    Skill("grasp", "cube_on_bench", None, 12),
    Skill("pick", "cube_on_bench", None, 20),
)


def source(skill: Skill) -> str:
    """Return the name of the policy that Dexter has learned, here if none ships."""
    if skill.shipped is not None:
        return skill.shipped
    name = f"dexter_{skill.program}"
    program = cbdsl.load(skill.program, robot="dexter")
    cbdsl.learn(program, f"{name}.yaml", episodes=20, seed=0, backend="kinematic")
    return name


def load(skill: Skill, robot: str, policy: str | None = None) -> cbdsl.RunRequest:
    """Return the program of a skill on a robot, before a thing for its gripper."""
    values = {"hand": ARMS[robot].hand}
    return cbdsl.load(
        skill.program, robot=robot, stage=skill.stage.format(robot), values=values, policy=policy
    )


def scratch(skill: Skill, robot: str, seed: int, episodes: int) -> list[bool]:
    """Return which episodes are good while a policy is learned."""
    program = load(skill, robot)
    return _learned(skill, program, f"{robot}_{skill.program}_{seed}", seed, episodes, None)


def transferred(skill: Skill, robot: str, seed: int, episodes: int, policy: str) -> list[bool]:
    """Return which episodes are good with a policy of another robot."""
    program = load(skill, robot)
    name = f"{robot}_{skill.program}_from_{seed}"
    try:
        return _learned(skill, program, name, seed, episodes, policy)
    except cbdsl.UsageError as error:
        if "no context to learn" not in str(error):
            raise
    program = load(skill, robot, policy)
    results = cbdsl.run(program, seed=1000 * seed, episodes=episodes, backend="kinematic")
    return [each.rewarded and len(each.actions) <= skill.transitions for each in results]


def _learned(
    skill: Skill, program: cbdsl.RunRequest, name: str, seed: int, episodes: int, policy: str | None
) -> list[bool]:
    learner = None if policy is None else "transfer"
    outcome = cbdsl.learn(
        program, f"{name}.yaml", seed=seed, episodes=episodes, backend="kinematic",
        policy=policy, learner=learner,
    )  # fmt: skip
    return [
        any(each.reward for each in one.transitions) and len(one.transitions) <= skill.transitions
        for one in outcome.episodes
    ]


def first_of_good(episodes: Sequence[bool]) -> int | None:
    """Return the number of the first episode of a good window, from 1; None without one."""
    for first in range(len(episodes) - WINDOW + 1):
        if sum(episodes[first : first + WINDOW]) >= MOST:
            return first + 1
    return None


def arms(only: str) -> Iterator[str]:
    """Propose robots for models in the working folder, and yield the names of all that exist."""
    for name, arm in ARMS.items():
        if only and name not in only.split(","):
            continue
        if arm.package is not None:
            folder = folder_of(arm.package)
            if folder is None:
                print(f"{name}: {arm.package} is not installed")
                continue
            cbdsl.propose_robot(name, folder / arm.file, to=Path("robots"), cameras=True)
        write_stage(name, arm)
        yield name


def write_stage(robot: str, arm: Arm) -> None:
    """Write the stage with a thing between the pads of one robot's hand."""
    stages = Path("programs", "stages")
    text = (stages / "thing_between_pads.yaml").read_text("utf-8")
    name = f"between_pads_{robot}"
    text = text.replace("thing_between_pads", name).replace("hand: arm,", f"hand: {arm.arm},")
    (stages / f"{name}.yaml").write_text(text, "utf-8")


def main() -> None:
    """Print the episodes until each skill is learned, by robot."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--trials", type=int, default=10)
    parser.add_argument("--episodes", type=int, default=20)
    parser.add_argument("--only", default="", help="arms, with commas between them")
    options = parser.parse_args()
    with TemporaryDirectory() as folder:
        shutil.copytree(HERE / "transfer" / "programs", Path(folder, "programs"))
        os.chdir(folder)
        robots = [*arms(options.only)]
        print("| skill | arm | from scratch | with Dexter's policy | ratio |")
        for skill in SKILLS:
            policy = source(skill)
            for robot in robots:
                print_row(skill, robot, policy, options.trials, options.episodes)


def print_row(skill: Skill, robot: str, policy: str, trials: int, episodes: int) -> None:
    """Print the medians of one skill on one arm; trials without success count all episodes."""
    seeds = range(1, trials + 1)
    both = (
        [scratch(skill, robot, seed, episodes) for seed in seeds],
        [transferred(skill, robot, seed, episodes, policy) for seed in seeds],
    )
    firsts = [[first_of_good(trial) for trial in one] for one in both]
    medians = [median(first or episodes + 1 for first in one) for one in firsts]
    cells = [
        f"{middle:g} ({trials - one.count(None)} of {trials})"
        for one, middle in zip(firsts, medians, strict=True)
    ]
    ratio = f"{medians[0] / medians[1]:.1f}"
    print(f"| `{skill.program}` | {robot} |", " | ".join((*cells, ratio)), "|", flush=True)


if __name__ == "__main__":
    main()
