"""Rest at targets at and beyond the reach of an arm, with this law and with others.

A planar arm of 3 to 6 joints has three tasks: the tip's position, its orientation, and a posture,
by strict priority or, in Pink, by weight. Joints integrate the displacements at 60 Hz for 10 s.
Distances are in lengths of the arm. For each solver and each range of distances, a row has

- the share of the targets at which a joint still oscillates in the last second, by more than
  0.005 deg a tick,
- the largest motion of a joint in the last second, deg a tick (median and 95 %),
- the distance of the tip beyond the least possible distance at the end, mm (median and 95 %).

Libraries that cannot be imported are named.

    python benchmarks/unreachable.py
"""

from __future__ import annotations

import argparse
import json
import math
import sys
from collections.abc import Callable, Iterator
from typing import Any, NamedTuple

import numpy as np
import pinocchio  # noqa: TID251 -- as Pink's users do
from ours import law_with_hessians
from peers import PERIOD

from cbdsl.numeric.arrays import Floats

RANGES = ((0.3, 0.9), (0.9, 0.999), (0.999, 1.02), (1.02, 1.6))
TICKS = 600
SWING = 0.005  # deg a tick
GAIN, SPEED, TURN, BEND = 8.0, 0.35, 1.5, 0.8  # 1/s, m/s, rad/s, rad/s
FRACTION = 0.5 * GAIN * PERIOD

Solver = Callable[[Floats], Floats]


class Scene(NamedTuple):
    """A planar arm and its target.

    Attributes:
        model: Pinocchio's model, with joints about z and links along x.
        length: Length of the arm, m.
        start: Joint positions at the start, rad, shape (n,).
        target: Place of the tip, with its orientation.
    """

    model: Any
    length: float
    start: Floats
    target: Any

    @property
    def least(self) -> float:
        """Least possible distance of the tip from the target, m."""
        return max(0.0, float(np.linalg.norm(self.target.translation)) - self.length)


def scene(seed: int, nearest: float, farthest: float) -> Scene:
    """Draw an arm, and a target at a distance in lengths of the arm."""
    rng = np.random.default_rng(seed)
    joints = int(rng.integers(3, 7))
    model, parent, offset = pinocchio.Model(), 0, pinocchio.SE3.Identity()
    lengths = rng.uniform(0.1, 0.35, joints)
    for number, length in enumerate(lengths):
        parent = model.addJoint(parent, pinocchio.JointModelRZ(), offset, f"joint {number}")
        inertia = pinocchio.Inertia.FromSphere(1.0, 0.05)
        model.appendBodyToJoint(parent, inertia, pinocchio.SE3.Identity())
        offset = pinocchio.SE3(np.eye(3), np.array([length, 0.0, 0.0]))
    model.addFrame(pinocchio.Frame("tip", parent, 0, offset, pinocchio.FrameType.OP_FRAME))
    model.lowerPositionLimit[:], model.upperPositionLimit[:] = -50.0, 50.0
    model.velocityLimit[:] = 1.5
    way, turn = rng.uniform(-1.0, 1.0), rng.uniform(-1.5, 1.5)
    distance = lengths.sum() * rng.uniform(nearest, farthest)
    place = distance * np.array([math.cos(way), math.sin(way), 0.0])
    target = pinocchio.SE3(pinocchio.exp3(np.array([0.0, 0.0, turn])), place)
    return Scene(model, float(lengths.sum()), rng.uniform(-0.8, 0.8, joints), target)


def ours(case: Scene, order: int) -> Solver:
    """Return a solver with strict priorities, of first or second order."""
    data, tip = case.model.createData(), case.model.getFrameId("tip")
    joints = case.model.nq
    solve = law_with_hessians((2, 1, joints), FRACTION, curved=order == 2)
    home = np.zeros((joints, joints, joints))

    def step(q: Floats) -> Floats:
        pinocchio.computeJointJacobians(case.model, data, q)
        frame = pinocchio.updateFramePlacement(case.model, data, tip)
        rows = pinocchio.getFrameJacobian(case.model, data, tip, pinocchio.LOCAL_WORLD_ALIGNED)
        away = case.target.translation - frame.translation
        turn = pinocchio.log3(case.target.rotation @ frame.rotation.T)[2]
        hessian = np.zeros((2, joints, joints))
        for i in range(joints):
            for j in range(i, joints):
                # All axes are z: a lever turns by a right angle.
                hessian[:, i, j] = hessian[:, j, i] = -rows[1, j], rows[0, j]
        far = FRACTION * away[:2]
        far *= min(1.0, SPEED * PERIOD / max(float(np.linalg.norm(far)), 1e-12))
        wanted = np.clip(np.array([FRACTION * turn]), -TURN * PERIOD, TURN * PERIOD)
        bend = np.clip(-FRACTION * q, -BEND * PERIOD, BEND * PERIOD)
        return solve(
            [
                (rows[:2], far, hessian),
                (rows[5:], wanted, np.zeros((1, joints, joints))),
                (np.eye(joints), bend, home),
            ],
            q,
        )

    return step


def pink(case: Scene) -> Solver:
    """Return a solver of weighted tasks in one quadratic program."""
    from pink import Configuration, solve_ik
    from pink.tasks import FrameTask, PostureTask

    configuration = Configuration(case.model, case.model.createData(), case.start)
    reach = FrameTask("tip", position_cost=1.0, orientation_cost=0.03, gain=FRACTION)
    reach.set_target(case.target)
    posture = PostureTask(cost=1e-3, gain=FRACTION)
    posture.set_target(np.zeros(case.model.nq))

    def step(q: Floats) -> Floats:
        configuration.update(q)
        found: Floats = PERIOD * solve_ik(configuration, [reach, posture], PERIOD, solver="daqp")
        return found

    return step


def settle(case: Scene, step: Solver) -> tuple[float, float, float]:
    """Return swing and motion in the last second, deg a tick, and the excess distance, mm."""
    q, moves = case.start.copy(), []
    for _ in range(TICKS):
        moves.append(step(q))
        q = q + moves[-1]
    last = np.degrees(np.array(moves[-round(1 / PERIOD) :]))
    # A steady motion covers the distance of its displacements: sum |dq| = |sum dq|. The difference
    # is the part of the motion that goes back and forth.
    swing = float((np.abs(last).sum(0) - np.abs(last.sum(0))).max()) / len(last)
    data = case.model.createData()
    pinocchio.framesForwardKinematics(case.model, data, q)
    place = data.oMf[case.model.getFrameId("tip")].translation
    distance = float(np.linalg.norm(place - case.target.translation))
    return swing, float(np.abs(last).max()), 1000 * (distance - case.least)


def rows(targets: int, seed: int) -> Iterator[dict[str, Any]]:
    """Yield a result for each solver and range."""
    solvers: dict[str, Callable[[Scene], Solver]] = {
        "cbdsl": lambda case: ours(case, 2),
        "cbdsl, first order": lambda case: ours(case, 1),
        "pink daqp": pink,
    }
    for name, make in solvers.items():
        for nearest, farthest in RANGES:
            try:
                cases = [scene(seed + number, nearest, farthest) for number in range(targets)]
                found = np.array([settle(case, make(case)) for case in cases])
            except ImportError as error:
                yield {"solver": name, "missing": str(error)}
                break
            yield {
                "solver": name,
                "range": [nearest, farthest],
                "targets": targets,
                "swinging": float(np.mean(found[:, 0] > SWING)),
                "motion": np.quantile(found[:, 1], (0.5, 0.95)).round(4).tolist(),
                "excess": np.quantile(found[:, 2], (0.5, 0.95)).round(2).tolist(),
            }


def main() -> None:
    """Print a row for each solver and range."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--targets", type=int, default=40, help="in each range")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--json", action="store_true", help="print one JSON object a row")
    options = parser.parse_args()
    for row in rows(options.targets, options.seed):
        if options.json:
            line = json.dumps(row)
        elif "missing" in row:
            line = f"{row['solver']} is missing: {row['missing']}"
        else:
            line = (
                f"{row['solver']:20}{row['range']!s:16} swinging {100 * row['swinging']:3.0f} %"
                f"  motion {row['motion']} deg a tick  excess {row['excess']} mm"
            )
        sys.stdout.write(line + "\n")
        sys.stdout.flush()


if __name__ == "__main__":
    main()
