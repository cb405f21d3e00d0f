"""Rest of random stacks on random and public arms, half of them with targets out of reach.

Random arms have 3 to 9 joints, planar or spatial, with limits; public ones come from
``pybullet_data``. A stack has 1 to 5 levels of the tip's position, whole or by axes, its
orientation, and the posture. Episodes last 10 s on the engine that ``--backend`` names. A row gives

- the share at rest: no joint moves by more than 0.02 deg a tick in the last second,
- the share whose first level ends within 2 mm or 0.5 deg of the nearest posture that scipy finds
  from the final posture (a local law ends in a local optimum), and from 8 random ones,
- the share whose levels all end so near the best that scipy finds from the final posture, while
  the errors of the levels above stay as they are,

with Clopper-Pearson intervals of 95 %. Run with ``python benchmarks/resting_arms.py``.
"""

from __future__ import annotations

import argparse
import json
import math
import sys
import tempfile
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from scipy.optimize import least_squares
from scipy.spatial.transform import Rotation

from cbdsl.api.open_robot import OpenRobot, open_robot
from cbdsl.numeric.arrays import Floats
from cbdsl.numeric.proportion import exact_interval

STACKS = ("p", "r", "pr", "rp", "pq", "prq", "zhq", "zhrq", "zyxrq")
STILL, NEAR, TURNED = 0.02, 2e-3, math.radians(0.5)  # deg a tick, m, rad
HELD = 1e3  # weight of the levels above in the optimiser
NAMES = {"p": "move", "r": "turn", "q": "home", "z": "up", "h": "level", "y": "aside", "x": "ahead"}
AXES = {"x": [0], "y": [1], "z": [2], "h": [0, 1]}
PUBLIC = (
    ("franka_panda/panda", "panda_link0", "panda_joint{}", 7, "panda_hand", 1.1),
    ("kuka_iiwa/model", "lbr_iiwa_link_0", "lbr_iiwa_joint_{}", 7, "lbr_iiwa_link_7", 1.2),
    ("xarm/xarm6_robot", "world", "joint{}", 6, "link6", 0.8),
)
CONTROL = """control:
  rate: 60 Hz
  joint_speed: 1.5 rad/s
  limit_margin: 0.002 rad
  tasks:
    configuration: {gain: 8 /s, speed: 1.5 rad/s, quiescence: {rate: 1e-3, window: 0.3 s}}
    position:
      {gain: 8 /s, speed: 35 cm/s, acceleration: 1.5 m/s^2, quiescence: {rate: 1e-4, window: 0.3 s}}
    orientation: {gain: 8 /s, speed: 1.5 rad/s, quiescence: {rate: 1e-2, window: 0.3 s}}
"""


class Case(NamedTuple):
    """Arm, stack and target.

    Attributes:
        urdf: Path of the model.
        base: Name of the first link.
        joints: Names of the joints.
        tip: Name of the last link.
        stack: Levels, highest priority first, as the letters of ``NAMES``.
        position: Target, m, shape (3,).
        turn: Target orientation as a rotation vector, rad, shape (3,).
        start: Joint positions at the start, rad, shape (n,).
    """

    urdf: str
    base: str
    joints: list[str]
    tip: str
    stack: str
    position: Floats
    turn: Floats
    start: Floats


def arm(folder: Path, rng: np.random.Generator) -> tuple[str, list[str], str, float]:
    """Write the model of a random arm; return its path, joints, tip and length."""
    count, planar = int(rng.integers(3, 10)), bool(rng.random() < 0.4)
    length, limit = rng.uniform(0.6, 1.2), float(rng.choice([2.0, 3.0]))
    links = rng.uniform(0.5, 1.5, count)
    links *= length / links.sum()
    inertia = (
        '<inertial><mass value="0.3"/><inertia ixx="0.003" iyy="0.003" izz="0.003" '
        'ixy="0" ixz="0" iyz="0"/></inertial>'
    )
    parts = ['<robot name="arm"><link name="base"/>']
    for number in range(count):
        axis = "0 0 1" if planar else ("0 0 1", "0 1 0", "1 0 0")[int(rng.integers(3))]
        along = links[number - 1] if number else 0.0
        parent = f"link{number - 1}" if number else "base"
        parts.append(
            f'<link name="link{number}">{inertia}</link><joint name="j{number}" type="revolute">'
            f'<parent link="{parent}"/><child link="link{number}"/><origin xyz="{along} 0 0"/>'
            f'<axis xyz="{axis}"/><limit lower="{-limit}" upper="{limit}" effort="200" '
            'velocity="2"/></joint>'
        )
    parts.append(
        f'<link name="tip">{inertia}</link><joint name="end" type="fixed"><parent '
        f'link="link{count - 1}"/><child link="tip"/><origin xyz="{links[-1]} 0 0"/></joint>'
    )
    path = folder / "arm.urdf"
    path.write_text("".join(parts) + "</robot>", "utf-8")
    return str(path), [f"j{number}" for number in range(count)], "tip", length


def case(seed: int, folder: Path) -> Case:
    """Draw a case; every fourth arm is public, and targets of odd seeds are out of reach."""
    rng = np.random.default_rng(seed)
    if seed % 4 == 3:
        import pybullet_data

        name, base, form, count, tip, length = PUBLIC[int(rng.integers(len(PUBLIC)))]
        joints = [form.format(number) for number in range(1, count + 1)]
        urdf = str(Path(pybullet_data.getDataPath()) / f"{name}.urdf")
    else:
        base, (urdf, joints, tip, length) = "base", arm(folder, rng)
    way = rng.normal(size=3)
    shares = (1.05, 1.5) if seed % 2 else (0.3, 0.8)
    position = length * rng.uniform(*shares) * way / np.linalg.norm(way)
    return Case(
        urdf, base, joints, tip, str(rng.choice(STACKS)), position, rng.uniform(-1.5, 1.5, 3),
        rng.uniform(0.1, 0.6, len(joints)),
    )  # fmt: skip


def posture(it: Case) -> list[float]:
    """Return the joint positions at the start, which are also the last level's target, rad."""
    start = it.start.tolist()
    if "panda" in it.tip or "link6" in it.tip:
        start[3 if "panda" in it.tip else 2] = -1.5  # 0 is beyond the limits of these joints
    return list(start)


def write(it: Case, folder: Path) -> Path:
    """Write the documents of a case; return its program."""
    joints = json.dumps(it.joints)
    start = [f"{angle:.4f}" for angle in posture(it)]
    robot = (
        "cbdsl: 1\nkind: robot\nname: arm\n"
        f"model: {it.urdf}\nbase: {it.base}\n{CONTROL}effectors:\n  arm:\n    joints: {joints}\n"
        f"    tip: {{link: {it.tip}, offset: [0 m, 0 m, 0 m]}}\n"
        f"    postures: {{ready: [{', '.join(start)}]}}\n    start: ready\n"
    )
    position = ", ".join(f"{value:.4f} m" for value in it.position)
    turn = ", ".join(f"{value:.4f}" for value in it.turn)
    forms = {
        "p": f"reference: [{position}], feedback: arm.position, effector: arm.position",
        "r": f"reference: [{turn}], feedback: arm.orientation, effector: arm.orientation",
        "q": "reference: arm.ready, feedback: arm, effector: arm",
    }
    for letter, axes in AXES.items():
        along = ", ".join(f"{it.position[axis]:.4f} m" for axis in axes)
        named = ", ".join("xyz"[axis] for axis in axes)
        forms[letter] = (
            f"reference: [{along}], feedback: arm.position, effector: arm.position, axes: [{named}]"
        )
    levels = [NAMES[letter] for letter in it.stack]
    stack = " ◁ ".join(reversed(levels))
    others = "".join(f", {name}" for name in levels) if len(levels) > 1 else ""
    controllers = "".join(
        f"  {NAMES[each]}: {{potential: spring, {forms[each]}}}\n" for each in it.stack
    )
    states = ["X" * len(it.stack), "0" + "*" * (len(it.stack) - 1), "1" + "*" * (len(it.stack) - 1)]
    policy = ", ".join(f'"{state}": {stack}' for state in states)
    program = (
        "cbdsl: 1\nkind: program\nname: go\nrobot: arm\nstage: bench\n"
        f"controllers:\n{controllers}actions: [{stack}{others}]\npolicy: {{{policy}}}\n"
        "limits: {transition_time: 10 s, episode_time: 10 s}\n"
    )
    (folder / "robots").mkdir()
    (folder / "programs" / "stages").mkdir(parents=True)
    (folder / "robots" / "arm.yaml").write_text(robot, "utf-8")
    stage = "cbdsl: 1\nkind: stage\nname: bench\nrobot: arm\ncontexts: {empty: {}}\n"
    (folder / "programs" / "stages" / "bench.yaml").write_text(stage, "utf-8")
    (folder / "programs" / "go.yaml").write_text(program, "utf-8")
    return folder / "programs" / "go.yaml"


class Errors:
    """Errors of the levels, by forward kinematics."""

    def __init__(self, robot: OpenRobot, it: Case) -> None:
        self._kinematics, self._case = robot.kinematics, it
        self._own = robot.kinematics.joints.pick(it.joints)
        self._goal = Rotation.from_rotvec(it.turn)
        whole = self._kinematics
        self.bounds = whole.lower[self._own] + 3e-3, whole.upper[self._own] - 3e-3

    def own(self, positions: Floats) -> Floats:
        """Return the arm's part of all joint positions."""
        own: Floats = positions[self._own]
        return own

    def __call__(self, q: Floats) -> Floats:
        """Return the residual of the first level, m or rad."""
        return self.of(self._case.stack[0], q)

    def of(self, letter: str, q: Floats) -> Floats:
        """Return the residual of a level, m or rad."""
        if letter == "q":
            home: Floats = np.array(posture(self._case)) - q
            return home
        whole = self._kinematics.positions.copy()
        whole[self._own] = q
        self._kinematics.update(whole)
        frame = self._kinematics.frame(self._case.tip)
        if letter == "r":
            turn: Floats = (self._goal * Rotation.from_matrix(frame.rotation).inv()).as_rotvec()
            return turn
        away: Floats = self._case.position - frame.position
        return away[AXES.get(letter, [0, 1, 2])]

    def best(self, start: Floats) -> float:
        """Return the least error that an optimiser reaches from a posture."""
        return float(np.linalg.norm(self(self._minimise(self, start))))

    def beyond(self, end: Floats) -> list[float]:
        """Return how much each level's error exceeds the best, with those above as they are."""
        # Level k minimises its own error e_k, while the errors e_j of all levels j above stay as
        # they are. The optimiser replaces these equations by a penalty, the residuals HELD (e_j -
        # held_j).
        found = []
        for place, letter in enumerate(self._case.stack):
            above = self._case.stack[:place]
            held = [self.of(each, end) for each in above]

            best = self._minimise(partial(self._below, letter, above, held), end)
            error, least = (float(np.linalg.norm(self.of(letter, q))) for q in (end, best))
            found.append(max(error - least, 0.0))
        return found

    def _below(self, letter: str, above: str, held: list[Floats], q: Floats) -> Floats:
        """Return a level's residual behind the weighted changes of those above."""
        kept = [HELD * (self.of(each, q) - e) for each, e in zip(above, held, strict=True)]
        return np.concatenate([*kept, self.of(letter, q)])

    def _minimise(self, residual: Callable[[Floats], Floats], start: Floats) -> Floats:
        """Return the posture of the least square error near a posture."""
        # ``least_squares`` requires a start strictly within the bounds.
        inside = np.clip(start, self.bounds[0] + 1e-6, self.bounds[1] - 1e-6)
        found = least_squares(residual, inside, bounds=self.bounds, xtol=1e-12, ftol=1e-12)
        best: Floats = found.x
        return best


def settle(seed: int, backend: str) -> dict[str, Any]:
    """Run a case; return its motion at rest, deg a tick, and its excess errors, m or rad."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        it = case(seed, folder)
        with open_robot(write(it, folder), backend=backend) as robot:
            first, moves = Errors(robot, it), []
            robot.run(0, on_tick=lambda tick: moves.append(tick.observation.positions.copy()))
            end = first.own(moves[-1])
            error = float(np.linalg.norm(first(end)))
            # An episode lasts 10 s, so that this is the number of ticks in its last second.
            ticks = round(len(moves) / 10.0)
            last = np.degrees([first.own(each) for each in moves[-ticks - 1 :]])
            rng = np.random.default_rng(seed)
            starts = [rng.uniform(*first.bounds) for _ in range(8)]
            # The optimiser stays farther from the joint limits than the law, and may end worse than
            # it began.
            local = min(first.best(end), error)
            beyond = first.beyond(end)
            best = min([local, *(first.best(start) for start in starts)])
    bounds = [TURNED if letter in "rq" else NEAR for letter in it.stack]
    bound, all_near = bounds[0], all(b <= m for b, m in zip(beyond, bounds, strict=True))
    return {
        "seed": seed, "stack": it.stack, "joints": len(it.joints),
        "motion": round(float(np.abs(np.diff(last, axis=0)).max()), 4),
        "beyond_local": round(error - local, 5), "beyond_best": round(error - best, 5),
        "beyond_levels": [round(each, 5) for each in beyond], "near_levels": all_near,
        "near_local": error - local <= bound, "near_best": error - best <= bound,
    }  # fmt: skip


def share(flags: list[bool]) -> str:
    """Return a share with its interval."""
    low, high = exact_interval(sum(flags), len(flags))
    return f"{sum(flags)} of {len(flags)} ({100 * low:.1f} to {100 * high:.1f} %)"


def main() -> None:
    """Print one row for each case that moves or is off, and the shares."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--cases", type=int, default=60)
    parser.add_argument("--seed", type=int, default=0, help="of the first case")
    parser.add_argument("--backend", default="kinematic")
    options = parser.parse_args()
    rows = []
    for seed in range(options.seed, options.seed + options.cases):
        row = settle(seed, options.backend)
        rows.append(row)
        if row["motion"] > STILL or not (row["near_best"] and row["near_levels"]):
            sys.stdout.write(json.dumps(row) + "\n")
            sys.stdout.flush()
    still = share([row["motion"] <= STILL for row in rows])
    local = share([row["near_local"] for row in rows])
    best = share([row["near_best"] for row in rows])
    levels = share([row["near_levels"] for row in rows])
    line = f"at rest {still}; near local {local}; all levels {levels}; near best {best}"
    sys.stdout.write(f"{options.backend}: {line}\n")


if __name__ == "__main__":
    main()
