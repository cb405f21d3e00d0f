"""Truth of the endings of reaches: causes in the result against an independent search.

Each arm reaches for ten targets with a stack of one or two levels, on the engine ``kinematic``:
near ones, far ones, ones out of reach, and targets on the axis of an arm that starts stretched. The
sentence and the causes of the result are compared with Pinocchio and scipy, from the model's file:

- "arrived" by the tolerance, and distances within 2 mm or 0.3 deg;
- "out of reach" with 60 descents from random postures;
- "local optimum" with a constrained descent nearby;
- "limits" and "held by" with the same descent, with and without the named holder.

A false statement is printed.

    python benchmarks/true_endings.py --arms 20
"""

from __future__ import annotations

import argparse
import json
import math
import re
import sys
import tempfile
from collections import Counter
from collections.abc import Callable, Sequence
from itertools import product
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pinocchio  # noqa: TID251 -- the judge must not use the product's kinematics
from resting_arms import CONTROL, PUBLIC, arm
from scipy.optimize import least_squares

from cbdsl.api.open_robot import open_robot
from cbdsl.numeric.arrays import Floats
from cbdsl.numeric.proportion import exact_interval

KINDS = ("near", "far", "unreachable", "stretched", "folded")
STACKS = ("p", "p", "pr", "rp")
NAMES = {"p": "move", "r": "turn"}
TOLERANCES = {"p": 0.02, "r": math.radians(5.0)}
SLACK = {"p": 2e-3, "r": math.radians(0.3)}
STARTS = 60
NEARBY = 0.05  # rad
SECONDS = 25


class Arm(NamedTuple):
    """Model of an arm: file, base link, joints, tip link and length, m."""

    urdf: str
    base: str
    joints: list[str]
    tip: str
    length: float


class Judge:
    """Errors of an arm's levels by Pinocchio.

    Args:
        body: Arm.
        position: Target of the tip, m, shape (3,).
        rotation: Target orientation, shape (3, 3).
    """

    def __init__(self, body: Arm, position: Floats, rotation: Floats) -> None:
        self._model = pinocchio.buildModelFromUrdf(body.urdf)
        self._data, self._tip = self._model.createData(), self._model.getFrameId(body.tip)
        self._own = [self._model.joints[self._model.getJointId(name)].idx_q for name in body.joints]
        self.lower = self._model.lowerPositionLimit[self._own]
        self.upper = self._model.upperPositionLimit[self._own]
        self.position, self.rotation = position, rotation

    def pose(self, q: Floats) -> tuple[Floats, Floats]:
        """Return the tip's position and orientation."""
        whole = pinocchio.neutral(self._model)
        whole[self._own] = q
        pinocchio.framesForwardKinematics(self._model, self._data, whole)
        frame = self._data.oMf[self._tip]
        return frame.translation.copy(), frame.rotation.copy()

    def residual(self, letter: str, q: Floats) -> Floats:
        """Return the error of a level, m or rad, shape (3,)."""
        position, rotation = self.pose(q)
        if letter == "p":
            return self.position - position
        turn: Floats = pinocchio.log3(self.rotation @ rotation.T)
        return turn

    def error(self, letter: str, q: Floats) -> float:
        """Return the size of a level's error, m or rad."""
        return float(np.linalg.norm(self.residual(letter, q)))

    def least(self, letter: str, rng: np.random.Generator) -> float:
        """Return the least error in any posture."""
        best, bounds = math.inf, (self.lower + 1e-4, self.upper - 1e-4)
        for _ in range(STARTS):
            start = rng.uniform(*bounds)
            found = least_squares(lambda q: self.residual(letter, q), start, bounds=bounds)
            best = min(best, math.sqrt(2.0 * found.cost))
            if best < 1e-5:
                break
        return best

    def nearby(
        self, letter: str, above: str, q: Floats, bounds: tuple[Floats, Floats], reach: float
    ) -> float:
        """Return the least error near a posture while the levels above keep their errors."""
        held = {each: self.residual(each, q) for each in above}
        box = np.maximum(bounds[0], q - reach), np.minimum(bounds[1], q + reach)
        best = self.error(letter, q)
        for seed in range(6):
            rng = np.random.default_rng(seed)
            start = np.clip(q + rng.normal(size=len(q)) * 0.3 * reach, box[0] + 1e-9, box[1] - 1e-9)

            def cost(x: Floats) -> Floats:
                kept = [1e3 * (self.residual(each, x) - e) for each, e in held.items()]
                return np.concatenate([*kept, self.residual(letter, x)])

            x = least_squares(cost, start, bounds=box, xtol=1e-12, ftol=1e-12).x
            moved = [np.linalg.norm(self.residual(each, x) - e) for each, e in held.items()]
            if max(moved, default=0.0) < 1e-3:
                best = min(best, self.error(letter, x))
        return best


def body_of(number: int, folder: Path) -> Arm:
    """Return an arm: every fourth one is public, the others are random."""
    rng = np.random.default_rng([number, 1])
    if number % 4 == 3:
        import pybullet_data

        name, base, form, count, tip, length = PUBLIC[number // 4 % len(PUBLIC)]
        urdf = str(Path(pybullet_data.getDataPath()) / f"{name}.urdf")
        return Arm(urdf, base, [form.format(joint) for joint in range(1, count + 1)], tip, length)
    urdf, joints, tip, length = arm(folder, rng)
    return Arm(urdf, "base", joints, tip, length)


class Case(NamedTuple):
    """Reach: start, target and stack."""

    kind: str
    stack: str
    start: Floats
    position: Floats
    rotation: Floats


def case_of(kind: str, body: Arm, rng: np.random.Generator) -> Case:
    """Draw a reach of a kind."""
    judge = Judge(body, np.zeros(3), np.eye(3))
    middle, half = 0.5 * (judge.lower + judge.upper), 0.45 * (judge.upper - judge.lower)
    start = middle + rng.uniform(-0.5, 0.5, len(middle)) * half
    goal = start + rng.normal(size=len(start)) * (0.25 if kind == "near" else 1.0)
    position, rotation = judge.pose(np.clip(goal, middle - half, middle + half))
    if kind == "unreachable":
        way = rng.normal(size=3)
        position = body.length * rng.uniform(1.05, 1.6) * way / np.linalg.norm(way)
    if kind in ("stretched", "folded"):
        start = np.clip(np.zeros(len(start)), middle - half, middle + half)
        tip, rotation = judge.pose(start)
        share = rng.uniform(0.2, 0.9) if kind == "stretched" else -rng.uniform(0.2, 0.9)
        position = share * tip
    return Case(kind, str(rng.choice(STACKS)), start, position, rotation)


def write(it: Case, body: Arm, folder: Path) -> Path:
    """Write the documents of a case; return its program."""
    start = ", ".join(f"{angle:.5f}" for angle in it.start)
    robot = (
        f"cbdsl: 1\nkind: robot\nname: arm\nmodel: {body.urdf}\nbase: {body.base}\n{CONTROL}"
        f"effectors:\n  arm:\n    joints: {json.dumps(body.joints)}\n"
        f"    tip: {{link: {body.tip}, offset: [0 m, 0 m, 0 m]}}\n"
        f"    postures: {{ready: [{start}]}}\n    start: ready\n"
    )
    position = ", ".join(f"{value:.5f} m" for value in it.position)
    turn = ", ".join(f"{value:.6f}" for value in pinocchio.log3(it.rotation))
    forms = {
        "p": f"reference: [{position}], feedback: arm.position, effector: arm.position",
        "r": f"reference: [{turn}], feedback: arm.orientation, effector: arm.orientation",
    }
    levels = [NAMES[letter] for letter in it.stack]
    lines = "".join(f"  {NAMES[e]}: {{potential: spring, {forms[e]}}}\n" for e in it.stack)
    stack, count = " ◁ ".join(reversed(levels)), len(levels)
    others = f", {', '.join(levels)}" if count > 1 else ""
    states = ["X" * count, *map("".join, product("01", repeat=count))][:-1]
    policy = ", ".join(f'"{state}": {stack}' for state in states)
    program = (
        "cbdsl: 1\nkind: program\nname: go\nrobot: arm\nstage: bench\n"
        f"controllers:\n{lines}actions: [{stack}{others}]\npolicy: {{{policy}}}\n"
        f'success: ["{"1" * count}"]\n'
        f"limits: {{transitions: 1000, transition_time: {SECONDS} s, episode_time: {SECONDS} s}}\n"
    )
    (folder / "robots").mkdir(exist_ok=True)
    (folder / "programs" / "stages").mkdir(parents=True, exist_ok=True)
    (folder / "robots" / "arm.yaml").write_text(robot, "utf-8")
    stage = "cbdsl: 1\nkind: stage\nname: bench\nrobot: arm\ncontexts: {empty: {}}\n"
    (folder / "programs" / "stages" / "bench.yaml").write_text(stage, "utf-8")
    (folder / "programs" / "go.yaml").write_text(program, "utf-8")
    return folder / "programs" / "go.yaml"


class Ending(NamedTuple):
    """Result of a reach, with the final posture, rad, shape (n,)."""

    outcome: str
    sentence: str
    causes: dict[str, str]
    q: Floats


def reach(it: Case, body: Arm, folder: Path) -> Ending:
    """Run a case on the engine ``kinematic``."""
    with open_robot(write(it, body, folder), backend="kinematic") as robot:
        positions: list[Floats] = []
        result = robot.run(0, on_tick=lambda tick: positions.append(tick.observation.positions))
        own = robot.kinematics.joints.pick(body.joints)
    return Ending(result.outcome, result.ending, dict(result.causes), positions[-1][own])


def falsehoods(it: Case, body: Arm, ending: Ending) -> list[str]:
    """Return the false statements of an ending."""
    judge, found = Judge(body, it.position, it.rotation), []
    for place, letter in enumerate(it.stack):
        name, error = NAMES[letter], judge.error(letter, ending.q)
        stated = re.search(rf"{name} [^;(]*?([\d.]+) (cm|deg) from", ending.sentence)
        if stated is None:
            found.append(f"{name}: no distance")
            continue
        distance = float(stated[1]) * (0.01 if stated[2] == "cm" else math.pi / 180)
        if abs(distance - error) > SLACK[letter]:
            found.append(f"{name}: is {error:.4f} from its target")
        arrived = ending.outcome == "success" or f"{name} came to rest" in ending.sentence
        if arrived and error > TOLERANCES[letter] + 1e-3:
            found.append(f"{name}: has not arrived, {error:.4f}")
        if name in ending.causes:
            why = ending.causes[name]
            false = _false_cause(judge, it.stack, place, why, ending, error)
            found += [f"{name}: {why}: {false}"] if false else []
    if ending.outcome == "success" and ending.causes:
        found.append("succeeded although stuck")
    return found


def _false_cause(
    judge: Judge, stack: str, place: int, why: str, ending: Ending, error: float
) -> str:
    """Return the reason why a cause is false, or an empty text."""
    letter, above, q = stack[place], stack[:place], ending.q
    slack = max(SLACK[letter], 0.02 * error)
    inner, margin = (judge.lower + 2e-3, judge.upper - 2e-3), 0.3
    wider = judge.lower - margin, judge.upper + margin
    if why == "out of reach":
        return _false_reach(judge, letter, ending, slack)
    nearest = judge.nearby(letter, above, q, inner, NEARBY)
    if why == "local optimum":
        return f"{nearest:.4f} is nearby" if error - nearest > slack else ""
    if why == "joint limits":
        if error - nearest > slack:
            return f"{nearest:.4f} is nearby within the limits"
        free = judge.nearby(letter, above, q, wider, margin)
        return "" if error - free > 1e-4 else "no limit holds it"
    if why.startswith("held by"):
        holders = [each for each in above if NAMES[each] in why]
        if error - nearest > slack:
            return f"{nearest:.4f} is nearby"
        rest = "".join(each for each in above if each not in holders)
        free = judge.nearby(letter, rest, q, wider if "limits" in why else inner, margin)
        return "" if error - free > 1e-4 else "nothing holds it"
    if why == "singular posture":
        return "" if error - nearest > -1e-9 else "no way out"
    if why == "creeping":
        return "" if error - nearest > 1e-4 else "it cannot come nearer"
    return "unknown cause"


def _false_reach(judge: Judge, letter: str, ending: Ending, slack: float) -> str:
    """Return the reason why a target is within reach, or no other posture as near as stated."""
    least = judge.least(letter, np.random.default_rng(5))
    if least <= TOLERANCES[letter]:
        return f"a posture comes within {least:.4f}"
    other = re.search(r"another posture is ([\d.]+) (cm|deg) away", ending.sentence)
    if other is None:
        return ""
    stated = float(other[1]) * (0.01 if other[2] == "cm" else math.pi / 180)
    return f"the least distance is {least:.4f}" if least - stated > slack else ""


def endings(
    arms: Sequence[int], count: int, show: Callable[[str], object] = print
) -> tuple[Counter[str], int]:
    """Run reaches of some arms; return the number of each ending, and of those with falsehoods."""
    seen: Counter[str] = Counter()
    false = 0
    for number in arms:
        with tempfile.TemporaryDirectory() as name:
            folder = Path(name)
            body = body_of(number, folder)
            for place in range(count):
                rng = np.random.default_rng([number, place, 2])
                it = case_of(KINDS[place % len(KINDS)], body, rng)
                ending = reach(it, body, folder)
                wrong = falsehoods(it, body, ending)
                false += bool(wrong)
                seen[_label(ending)] += 1
                if wrong:
                    row: dict[str, Any] = {"arm": number, "reach": place, "kind": it.kind}
                    row |= {"stack": it.stack, "ending": ending.sentence, "false": wrong}
                    show(json.dumps(row))
    return seen, false


def _label(ending: Ending) -> str:
    if ending.causes:
        return re.sub(r"held by .*", "held by", next(iter(ending.causes.values())))
    return ending.outcome or "not at rest"


def main() -> None:
    """Print one row for each false ending, and the counts."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--arms", type=int, default=20)
    parser.add_argument("--first", type=int, default=0, help="number of the first arm")
    parser.add_argument("--reaches", type=int, default=10, help="per arm")
    options = parser.parse_args()
    arms = range(options.first, options.first + options.arms)
    seen, false = endings(arms, options.reaches)
    total = options.arms * options.reaches
    low, high = exact_interval(false, total)
    sys.stdout.write(f"false: {false} of {total} ({100 * low:.1f} to {100 * high:.1f} %)\n")
    sys.stdout.write(f"{json.dumps(dict(seen.most_common()))}\n")


if __name__ == "__main__":
    main()
