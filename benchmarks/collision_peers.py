"""Crossing arms below a least distance of 2 cm: this package, pink and mink on the same pairs.

Dexter's two arms, with all other joints fixed, start in the same posture and send their hands to
crossed targets. All keep the same pairs of links apart: each pair of a link of the left arm and one
of the right arm. pink has a ``SelfCollisionBarrier`` for all pairs (gain 20, as in its examples),
mink a ``CollisionAvoidanceLimit`` that detects pairs within 8 cm, as this package does; both solve
with daqp, with the speed limits of the joints, and weigh the right hand 100 to 1. They integrate
their velocities exactly; this package runs on the kinematic engine.

coal measures the least distance between exact shapes in every tick. A tick without a solution
stands still and counts as unsolved. A row gives the least distance, cm, and the largest motion of a
joint in the last second, rad. The final errors of both hands follow, cm. Episodes run in turn; a
time is the median of all ticks, us of the processor, and its ratio to this package's.

    python benchmarks/collision_peers.py --programs 10
"""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Callable, Iterator
from itertools import product
from pathlib import Path
from time import process_time
from typing import Any

import mink
import mujoco  # noqa: TID251 -- as mink's users do
import numpy as np
import pink
import pinocchio  # noqa: TID251 -- as pink's users do
from control_peers import two_arms
from pink.barriers import SelfCollisionBarrier
from pink.exceptions import NoSolutionFound
from pink.limits import ConfigurationLimit, VelocityLimit
from stopwatch import Stopwatch

from cbdsl.api.load import load
from cbdsl.api.open_robot import open_robot
from cbdsl.kinematics.link_clearance import LinkClearance
from cbdsl.numeric.arrays import Floats
from cbdsl.robot.urdf_reader import read_urdf
from cbdsl.runtime.actuation import Actuation
from cbdsl.runtime.tick import Tick

PERIOD, TICKS, LEAST, NEAR, SPEED, ROWS = 1 / 60, 480, 0.02, 0.08, 1.5, 20
COSTS, GAIN = {"left": 1.0, "right": 10.0}, 8.0 * PERIOD
OURS = """cbdsl: 1
kind: program
name: cross
robot: two_arms
stage: empty
controllers:
  left: {{potential: spring, reference: [{0}], feedback: left_arm.position, effector: left_arm}}
  right: {{potential: spring, reference: [{1}], feedback: right_arm.position, effector: right_arm}}
actions: [left, right, left ◁ right]
policy: {{XX: left ◁ right, "**": left ◁ right}}
limits: {{transition_time: 8 s, episode_time: 8 s}}
"""
STAGE = "cbdsl: 1\nkind: stage\nname: empty\nrobot: two_arms\ncontexts: {empty: {}}\n"
Targets = dict[str, Floats]
Step = Callable[[Floats], Floats | None]


def targets_of(seed: int) -> Targets:
    """Draw crossed targets of both palms, m."""
    rng = np.random.default_rng(seed)
    low, high = (0.40, 0.12, 0.0), (0.60, 0.30, 0.25)
    return {
        side: rng.uniform(low, high) * (1, way, 1) for side, way in (("left", -1), ("right", 1))
    }


class Truth:
    """Distances of the pairs, and places of the palms, by Pinocchio and coal."""

    def __init__(self, urdf: Path, pairs: set[tuple[str, str]]) -> None:
        self.model = pinocchio.buildModelFromUrdf(str(urdf))
        self.shapes = pinocchio.buildGeomFromUrdf(
            self.model, str(urdf), pinocchio.GeometryType.COLLISION
        )
        self.data, links = self.model.createData(), dict[str, list[int]]()
        for number, shape in enumerate(self.shapes.geometryObjects):
            links.setdefault(self.model.frames[shape.parentFrame].name, []).append(number)
        for one, other in sorted(pairs):
            for first, second in product(links[one], links[other]):
                self.shapes.addCollisionPair(pinocchio.CollisionPair(first, second))
        self.apart = self.shapes.createData()

    def least(self, q: Floats) -> float:
        """Return the least distance of all pairs, m."""
        pinocchio.computeDistances(self.model, self.data, self.shapes, self.apart, q)
        return min(float(each.min_distance) for each in self.apart.distanceResults)

    def palm(self, q: Floats, side: str) -> Floats:
        """Return the place of a palm, m, shape (3,)."""
        pinocchio.framesForwardKinematics(self.model, self.data, q)
        place: Floats = self.data.oMf[self.model.getFrameId(f"{side}_palm")].translation.copy()
        return place


def pink_step(truth: Truth, targets: Targets, q: Floats) -> Step:
    """Return pink's step from a posture to the next one."""
    model = truth.model
    model.velocityLimit[:] = SPEED
    configuration = pink.Configuration(
        model, truth.data, q, collision_model=truth.shapes, collision_data=truth.apart
    )
    tasks = [pink.tasks.FrameTask(f"{side}_palm", COSTS[side], 0.0, gain=GAIN) for side in targets]
    for task, goal in zip(tasks, targets.values(), strict=True):
        task.set_target(pinocchio.SE3(np.eye(3), goal))
    barrier = SelfCollisionBarrier(ROWS, gain=20.0, d_min=LEAST)
    limits = ConfigurationLimit(model), VelocityLimit(model)

    def step(q: Floats) -> Floats | None:
        configuration.update(q)
        try:
            velocity = pink.solve_ik(
                configuration, tasks, PERIOD, "daqp", limits=limits, barriers=[barrier],
                safety_break=False,
            )  # fmt: skip
        except NoSolutionFound:
            return None
        after: Floats = q + PERIOD * velocity
        return after

    return step


def mink_step(urdf: Path, pairs: set[tuple[str, str]], targets: Targets, q: Floats) -> Step:
    """Return mink's step from a posture to the next one."""
    text = urdf.read_text("utf-8").replace(
        "</robot>", '<mujoco><compiler fusestatic="false" discardvisual="true"/></mujoco></robot>'
    )
    model = mujoco.MjModel.from_xml_string(text)
    shapes: dict[str, list[int]] = {}
    for shape in range(model.ngeom):
        shapes.setdefault(model.body(model.geom_bodyid[shape]).name, []).append(shape)
    configuration = mink.Configuration(model, q)
    tasks = [
        mink.FrameTask(f"{side}_palm", "body", COSTS[side], 0.0, gain=GAIN) for side in targets
    ]
    for task, goal in zip(tasks, targets.values(), strict=True):
        task.set_target(mink.SE3.from_translation(goal))
    speeds = {model.joint(joint).name: SPEED for joint in range(model.njnt)}
    limits = [
        mink.ConfigurationLimit(model),
        mink.VelocityLimit(model, speeds),
        mink.CollisionAvoidanceLimit(
            model, [(shapes[one], shapes[other]) for one, other in sorted(pairs)],
            minimum_distance_from_collisions=LEAST, collision_detection_distance=NEAR,
        ),
    ]  # fmt: skip

    def step(q: Floats) -> Floats | None:
        configuration.update(q)
        try:
            velocity = mink.solve_ik(configuration, tasks, PERIOD, "daqp", limits=limits)
        except mink.NoSolutionFound:
            return None
        return np.asarray(q + PERIOD * velocity)

    return step


def run_peer(step: Step, q: Floats) -> tuple[list[Floats], list[float], int]:
    """Return postures and times, us, of the ticks of an episode, and how many had no solution."""
    postures, times, unsolved = [q], list[float](), 0
    for _ in range(TICKS):
        start = process_time()
        after = step(postures[-1])
        times.append(1e6 * (process_time() - start))
        unsolved += after is None
        postures.append(postures[-1] if after is None else after)
    return postures, times, unsolved


def run_ours(folder: Path, targets: Targets, order: list[int]) -> tuple[list[Floats], list[float]]:
    """Return postures, in another order of joints, and times, us, of the ticks of an episode."""
    goals = [", ".join(f"{each:.4f} m" for each in targets[side]) for side in ("left", "right")]
    text = OURS.format(*goals)
    path, postures, ends = folder / "cross.yaml", list[Floats](), list[float]()
    path.write_text(text, "utf-8")
    request = load(path, clearance=f"{100 * LEAST:g} cm", rate=1 / PERIOD)
    with (
        Stopwatch({"move": [(Actuation, "move")]}, process_time) as watch,
        open_robot(request, backend="kinematic") as robot,
    ):

        def note(tick: Tick) -> None:
            ends.append(watch.seconds["move"])
            postures.append(tick.observation.positions[order])

        robot.run(0, on_tick=note)
    return postures, (1e6 * np.diff(ends)).tolist()


class Case:
    """Robot of two arms whose links keep their distances from the other arm's.

    Attributes:
        urdf: Model.
        pairs: Names of the links that keep a distance.
        names: Names of the joints in the order of a program.
        start: Positions of these joints at the start, rad, shape (14,).
    """

    def __init__(self, folder: Path) -> None:
        tree = read_urdf(folder / "two_arms.urdf")
        rest = ", ".join(link for link in tree.links if link.split("_")[0] not in COSTS)
        groups = ", ".join(f"[{side}_*, {rest}]" for side in COSTS)
        with (folder / "two_arms.yaml").open("a", encoding="utf-8") as file:
            file.write(f"\nclearance: {{ignore: [{groups}]}}\n")
        (folder / "empty.yaml").write_text(STAGE, "utf-8")
        (folder / "cross.yaml").write_text(OURS.format(*["0.4 m, 0 m, 0 m"] * 2), "utf-8")
        request = load(folder / "cross.yaml")
        links = LinkClearance(request.robot, tree, LEAST)
        self.folder, self.urdf, self.pairs = folder, folder / "two_arms.urdf", set(links.names)
        self.names, self.start = links.joints.names, links.start

    def episodes(self, seed: int) -> Iterator[tuple[dict[str, Any], list[float]]]:
        """Yield the row and the times, us, of each library's episode."""
        targets, truth = targets_of(seed), Truth(self.urdf, self.pairs)
        order = [self.names.index(name) for name in list(truth.model.names)[1:]]
        start = self.start[order]
        ours = *run_ours(self.folder, targets, order), 0
        peers = {
            "cbdsl": ours,
            "pink": run_peer(pink_step(truth, targets, start), start),
            "mink": run_peer(mink_step(self.urdf, self.pairs, targets, start), start),
        }
        for name, (postures, times, unsolved) in peers.items():
            last = postures[-1]
            errors = {
                side: round(100 * float(np.linalg.norm(truth.palm(last, side) - goal)), 1)
                for side, goal in targets.items()
            }
            least = 100 * min(truth.least(each) for each in postures)
            moved = float(np.abs(postures[-1 - round(1 / PERIOD)] - last).max())
            row = {"seed": seed, "name": name, "least": round(least, 2), "unsolved": unsolved}
            yield row | errors | {"moved": round(moved, 4)}, times


def main() -> None:
    """Print a row for each episode, and a summary of each library."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--programs", type=int, default=10)
    parser.add_argument("--seed", type=int, default=0, help="of the first program")
    options = parser.parse_args()
    times: dict[str, list[float]] = {}
    rows: dict[str, list[dict[str, Any]]] = {}
    with two_arms() as folder:
        case = Case(folder)
        for seed in range(options.seed, options.seed + options.programs):
            for row, spent in case.episodes(seed):
                times.setdefault(row["name"], []).extend(spent)
                rows.setdefault(row["name"], []).append(row)
                sys.stdout.write(json.dumps(row) + "\n")
                sys.stdout.flush()
    sys.stdout.write(f"{len(case.pairs)} pairs of links\n")
    own = float(np.median(times["cbdsl"]))
    for name, each in rows.items():
        median, least = float(np.median(times[name])), [row["least"] for row in each]
        below = sum(one < 100 * LEAST - 0.005 for one in least)
        arrived = sum(row["right"] < 1 for row in each)
        both = sum(max(row["left"], row["right"]) < 1 for row in each)
        resting = sum(row["moved"] < 0.01 for row in each)
        sys.stdout.write(
            f"{name}: {median:.0f} us, {median / own:.1f} times; least {min(least):.2f} cm, below"
            f" {100 * LEAST:g} cm in {below} of {len(least)}; within 1 cm: right {arrived}, both"
            f" {both}; at most 0.01 rad in the last second {resting}\n"
        )


if __name__ == "__main__":
    main()
