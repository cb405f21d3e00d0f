"""Contacts of Dexter's arms at crossed targets, with and without a clearance.

Each random program sends either hand 12 to 30 cm to the other side. The distances of all links are
those of coal between the exact shapes of the model, in every third measured posture. The law itself
uses other shapes and other code. Pairs that the robot document lets touch do not count. A row gives
the least distance, m, the final errors of both hands, m, and the outcome.

Run with ``python benchmarks/crossing_arms.py --clearance "2 cm"``.
"""

from __future__ import annotations

import argparse
import json
import sys
import tempfile
from itertools import combinations
from pathlib import Path
from typing import Any

import coal
import numpy as np

from cbdsl.api.load import load
from cbdsl.api.open_robot import OpenRobot, open_robot
from cbdsl.kinematics.link_tree import LinkTree
from cbdsl.kinematics.pose import Pose
from cbdsl.numeric.arrays import Floats
from cbdsl.numeric.proportion import exact_interval
from cbdsl.robot.joints import Joints
from cbdsl.robot.urdf_reader import read_urdf

PROGRAM = """cbdsl: 1
kind: program
name: cross
robot: dexter
stage: absent
controllers:
  left: {{potential: spring, reference: [{0}], feedback: left_arm.position, effector: left_arm}}
  right: {{potential: spring, reference: [{1}], feedback: right_arm.position, effector: right_arm}}
actions: [left, right, left ◁ right]
policy: {{XX: left ◁ right, 0*: left ◁ right, 10: left ◁ right}}
success: ["11"]
limits: {{transition_time: 8 s, episode_time: 8 s}}
"""
EVERY = 3  # ticks
MAKE = {"ball": coal.Sphere, "box": coal.Box, "cylinder": coal.Cylinder}


def write(seed: int, folder: Path) -> Path:
    """Write the program of a seed."""
    rng, targets = np.random.default_rng(seed), []
    for side in (-1.0, 1.0):
        x, y, z = rng.uniform((0.40, 0.12, 0.0), (0.60, 0.30, 0.25))
        targets.append(f"{x:.3f} m, {side * y:.3f} m, {z:.3f} m")
    path = folder / f"cross_{seed}.yaml"
    path.write_text(PROGRAM.format(*targets), "utf-8")
    return path


class Truth:
    """Distances between the links of a robot by its exact shapes."""

    def __init__(self, robot: OpenRobot) -> None:
        document = robot.request.robot
        model = read_urdf(robot.request.urdf)
        self._tree = LinkTree(model, Joints(document), document.base)
        self._shapes = {
            name: [(MAKE[s.kind](*s.size), Pose.at(s.origin)) for s in body.collisions]
            for name, body in model.bodies.items()
            if body.collisions
        }
        ways = {link: {j.parent for j in model.way(link)} for link in self._shapes}
        groups = document.simulation.no_contact

        def is_in(link: str, group: tuple[str, ...]) -> bool:
            return any(link.startswith(p[:-1]) if p[-1] == "*" else link == p for p in group)

        self._pairs = [
            (one, other)
            for one, other in combinations(self._shapes, 2)
            if one not in ways[other] and other not in ways[one]
            and not any(is_in(one, group) and is_in(other, group) for group in groups)
        ]  # fmt: skip

    def least(self, positions: Floats) -> tuple[float, str]:
        """Return the least distance in a posture, and its pair."""
        self._tree.update(positions)
        placed, least = {}, (np.inf, "")
        for link, shapes in self._shapes.items():
            at = self._tree.pose(link)
            poses = [at @ own for _, own in shapes]
            placed[link] = [
                (shape, coal.Transform3s(pose.rotation, pose.position))
                for (shape, _), pose in zip(shapes, poses, strict=True)
            ]
        request = coal.DistanceRequest()
        for one, other in self._pairs:
            for first in placed[one]:
                for second in placed[other]:
                    result = coal.DistanceResult()
                    distance = coal.distance(*first, *second, request, result)
                    if distance < least[0]:
                        least = float(distance), f"{one}, {other}"
        return least


def run(robot: OpenRobot, seed: int) -> dict[str, Any]:
    """Run the program of a seed; return its row."""
    postures: list[Floats] = []
    result = robot.run(
        seed, on_tick=lambda tick: postures.append(tick.observation.positions.copy())
    )
    truth = Truth(robot)
    distance, pair = min(truth.least(each) for each in postures[::EVERY])
    return {
        "seed": seed, "least": round(distance, 4), "pair": pair,
        "seconds": result.sim_seconds, "outcome": result.outcome, "ending": result.ending,
        "moved": round(float(np.abs(postures[-1] - postures[max(0, len(postures) - 30)]).max()), 4),
    }  # fmt: skip


def main() -> None:
    """Print a row for each program, and the number with contacts."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--programs", type=int, default=40)
    parser.add_argument("--seed", type=int, default=0, help="of the first program")
    parser.add_argument("--backend", default="kinematic")
    parser.add_argument("--clearance", default=None)
    options = parser.parse_args()
    rows = []
    with tempfile.TemporaryDirectory() as folder:
        for seed in range(options.seed, options.seed + options.programs):
            request = load(write(seed, Path(folder)), clearance=options.clearance)
            with open_robot(request, backend=options.backend) as robot:
                rows.append(run(robot, seed))
            sys.stdout.write(json.dumps(rows[-1]) + "\n")
            sys.stdout.flush()
    touched = sum(row["least"] <= 0.0 for row in rows)
    low, high = exact_interval(touched, len(rows))
    won = sum(row["outcome"] == "success" for row in rows)
    sys.stdout.write(
        f"{options.backend}: contacts in {touched} of {len(rows)} "
        f"({100 * low:.0f} to {100 * high:.0f} %); {won} succeed\n"
    )


if __name__ == "__main__":
    main()
