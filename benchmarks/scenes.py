"""Errors of the memory of several objects: separated, out of view, removed, and held.

Three balls lie on a table, two of them of one hue. In every image the robot's memory is compared
with the simulator's truth:

- ``in view``: both cameras see all of each ball. A position is correct within 1 cm; one outside of
  every ball of its hue is a ghost.
- ``anywhere``: some balls are out of view, cut off by an image's border, or occluded. Only ghosts
  count, since such balls may be unknown.
- ``remembered``: the head looks away for 10 s, so that no ball is in view, and back.
- ``removed``: one of the two balls is removed meanwhile. It has to be forgotten within 1 s after
  both cameras show its place, and nothing else may be.
- ``carried``: a hand takes one of two balls that both cameras see, and holds it above the other, of
  the same hue or not. The other ball and its remembered position must not move. Scenes in which the
  carry fails, such as those in which the hand pushes the other ball, are left out and counted.

Intervals are exact (Clopper-Pearson, 95 %). The exit status is 1 if a target is missed.

    python benchmarks/scenes.py --seed 5000000 --episodes 200 [--backend bullet] [--only removed]
"""

from __future__ import annotations

import argparse
import json
import math
import sys
from collections.abc import Callable, Iterator, Mapping
from itertools import combinations
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, NamedTuple

import numpy as np

from cbdsl.api.shipped import shipped_robot
from cbdsl.backends.backend import embody
from cbdsl.checking.program import check_program
from cbdsl.documents.stage import StageDocument
from cbdsl.kinematics.kinematics import Frame, Kinematics
from cbdsl.numeric.arrays import Floats
from cbdsl.numeric.proportion import exact_interval
from cbdsl.robot.resources import resources
from cbdsl.runtime.episode import Runner
from cbdsl.runtime.episode_observer import EpisodeListeners
from cbdsl.runtime.tick import Tick
from cbdsl.sensing.camera import within_view
from cbdsl.sensing.instances import Instances
from cbdsl.sensing.memory import PositionMemory
from cbdsl.sensing.signals import Signals
from cbdsl.yaml_text.library import Library, shipped

_TOP = -0.42  # of the table, m
_COLORS = {"hue_1": [1, 0, 0], "hue_7": [0, 0.4, 1]}
_TABLE = {"form": {"shape": "box", "size": [0.6, 1.2, 0.04]}, "position": [0.6, 0, -0.44]}
_RIGHT = 0.01  # largest error of a right position, m
_RUN = 0.05  # least displacement of an object that has run away, m
_SWAY = 0.02  # by how much the head turns to both sides, rad
_AWAY = {"pan": 1.4, "tilt": -0.3}
_CARRYING = {"pan": -0.25, "tilt": 1.1}

_CARRY = """\
cbdsl: 1
kind: program
name: carry
robot: dexter
parameters: {feature: red.1, goal: blue}
use:
  reachtouch: {program: reachtouch, with: {feature: $feature}}
controllers:
  hold:
    potential: spring
    reference: 6 N along normals
    feedback: right_hand.finger_forces
    effector: right_hand
    gain: 0.1 /s
    seek: {until: 1.5 rad}
    quiescence: {rate: 5, window: 0.5 s}
  carry:
    requires: hold
    potential: spring
    reference: stereo.$goal
    feedback: right_arm.position
    effector: right_arm.position
    speed: 25 cm/s
    standoff: {clearance: 16 cm, least: 22 cm, most: 30 cm}
  orient:
    requires: hold
    potential: spring
    reference: [180 deg, 0 deg, 0 deg]
    feedback: right_arm.orientation
    effector: right_arm.orientation
    free_axis: z
  above: orient ◁ carry ◁ hold
actions: [reachtouch, above]
policy: {XX: reachtouch, 0X: reachtouch, 1X: above, X0: above, X1: above}
limits: {transitions: 100, transition_time: 12 s}
"""


class Ball(NamedTuple):
    """A ball on the table: centre, m, shape (3,), radius, m, and the channel of its colour."""

    centre: Floats
    radius: float
    channel: str


class Outcome(NamedTuple):
    """Successes and trials of a scene, and whether it showed a ghost."""

    right: int
    tried: int
    ghost: bool = False


class Rig:
    """The robot before some balls.

    Args:
        backend: Name of the engine.
        cameras: ``rendered`` or ``ideal``.
    """

    def __init__(self, backend: str, cameras: str) -> None:
        self._library = Library(shipped())
        self.robot, urdf = shipped_robot("dexter", self._library)
        self._kinematics = Kinematics(self.robot, urdf)
        self.backend: Any = embody(backend, self.robot, urdf, cameras=cameras)
        named = resources(self.robot)
        self.signals = Signals(
            self.robot, self._kinematics, [named[f"stereo.{c}"] for c in _COLORS]
        )
        self.ghosts = 0

    @property
    def renderer(self) -> str:
        """Renderer of the images."""
        return str(self.backend.renderer)

    def frames(self, **joints: float) -> list[Frame]:
        """Return the frames of the cameras at some joints of the head."""
        positions = np.clip(0.0, self._kinematics.lower, self._kinematics.upper)
        for name, angle in joints.items():
            positions[self._kinematics.joints.index[name]] = angle
        self._kinematics.update(positions)
        return [self._kinematics.frame(camera.link) for camera in self.robot.cameras.values()]

    def are_whole(self, balls: list[Ball], **joints: float) -> bool:
        """Return True if both cameras see all of each ball, with a margin and unoccluded."""
        for camera, frame in zip(self.robot.cameras.values(), self.frames(**joints), strict=True):
            lines = [ball.centre - frame.position for ball in balls]
            for ball, line in zip(balls, lines, strict=True):
                if not within_view(camera, frame.rotation.T @ line, 1.15 * ball.radius):
                    return False
            for (one, a), (other, b) in combinations(zip(balls, lines, strict=True), 2):
                far, farther = math.hypot(*a), math.hypot(*b)
                between = math.acos(float(a @ b) / far / farther)
                sizes = math.asin(one.radius / far) + math.asin(other.radius / farther)
                if between < sizes + 2 * _SWAY * 0.1:
                    return False
        return True

    def show(self, balls: list[Ball], rng: np.random.Generator, **joints: float) -> None:
        """Begin anew before some balls."""
        fixtures = {"table": _TABLE | {"color": [0.6, 0.45, 0.3]}} | {
            f"ball_{number}": {
                "form": {"shape": "ball", "radius": ball.radius},
                "position": ball.centre.tolist(),
                "color": _COLORS[ball.channel],
            }
            for number, ball in enumerate(balls)
        }
        stage = _stage(fixtures=fixtures, contexts={"all": {"joints": joints}})
        self.backend.reset(stage, None, rng, list(_COLORS))
        self.signals.reset()
        self.balls = balls
        self._reference = self.backend.observe().positions.copy()
        self.ghosts = 0

    def look(self, seconds: float, **joints: float) -> Iterator[float]:
        """Let time pass while the head turns to some joints and sways; yields the time."""
        index = self.signals.joints.index
        for name, angle in joints.items():
            self._reference[index[name]] = angle
        period = self.backend.control_period
        for tick in range(round(seconds / period)):
            self.signals.update(self.backend.observe())
            self.ghosts += sum(1 for _ in self._strangers())
            reference = self._reference.copy()
            reference[index["pan"]] += _SWAY * math.sin(2 * math.pi * tick * period)
            self.backend.apply(reference)
            self.backend.step()
            yield (tick + 1) * period

    def instances(self, channel: str) -> Instances:
        """Return the remembered instances of a channel."""
        return self.signals.vision.instances[channel]

    def place(self, ball: Ball) -> tuple[int, float] | None:
        """Return the number of the memory nearest to a ball, and its distance, m."""
        memories = self.instances(ball.channel).memories
        errors = [
            (math.dist(memory.position, ball.centre), number)
            for number, memory in enumerate(memories)
            if memory.position is not None
        ]
        return min(((number, error) for error, number in errors), key=lambda e: e[1], default=None)

    def numbers(self) -> list[int | None]:
        """Return numbers of the balls that are remembered at the right place."""
        places = [self.place(ball) for ball in self.balls]
        return [None if place is None or place[1] > _RIGHT else place[0] for place in places]

    def _strangers(self) -> Iterator[PositionMemory]:
        """Yield the memories outside of every ball of their hue."""
        for channel in _COLORS:
            own = [ball for ball in self.balls if ball.channel == channel]
            for memory in self.instances(channel).memories:
                position = memory.position
                if position is not None and all(
                    math.dist(position, ball.centre) > ball.radius for ball in own
                ):
                    yield memory

    def shows(self, ball: Ball) -> bool:
        """Return True if both cameras are turned to a ball's place now."""
        return all(
            within_view(camera, pose.rotation.T @ (ball.centre - pose.position), 1.05 * ball.radius)
            for camera in self.robot.cameras.values()
            for pose in [self.backend.truth.link_pose(camera.link)]
        )

    def runner(self, goal: str, folder: Path) -> Runner:
        """Return the runner of the program that carries a ball above another."""
        file = folder / "carry.yaml"
        file.write_text(_CARRY, encoding="utf-8")
        program = check_program(file, {"goal": goal}, self._library)
        return Runner(self.robot, self._kinematics, program, self.backend)

    def close(self) -> None:
        """End the simulation."""
        self.backend.close()


def _stage(**sections: Any) -> StageDocument:
    head = {"cbdsl": 1, "kind": "stage", "name": "balls", "robot": "dexter"}
    return StageDocument.model_validate(head | sections)


def drawn(rng: np.random.Generator, wide: bool = False) -> list[Ball]:
    """Return three balls, two of one hue, with 2 cm or more between them."""
    balls: list[Ball] = []
    aside = 0.4 if wide else 0.22
    while len(balls) < 3:
        radius = rng.uniform(0.03, 0.07)
        centre = np.array([rng.uniform(0.4, 0.8), rng.uniform(-aside, aside), _TOP + radius])
        if all(math.dist(centre, b.centre) > radius + b.radius + 0.02 for b in balls):
            balls.append(Ball(centre, radius, "hue_7" if len(balls) == 2 else "hue_1"))
    return balls


def drawn_in_view(rig: Rig, rng: np.random.Generator) -> tuple[list[Ball], dict[str, float]]:
    """Return balls that both cameras see whole while the head sways, and its joints."""
    while True:
        balls = drawn(rng)
        joints = {"pan": rng.uniform(-0.1, 0.1), "tilt": rng.uniform(0.85, 1.2)}
        sways = (joints["pan"] - _SWAY, joints["pan"] + _SWAY)
        if all(rig.are_whole(balls, pan=pan, tilt=joints["tilt"]) for pan in sways):
            return balls, joints


def in_view(rig: Rig, rng: np.random.Generator) -> Outcome:
    """Run one scene."""
    balls, joints = drawn_in_view(rig, rng)
    rig.show(balls, rng, **joints)
    _exhaust(rig.look(1.0))
    right = [number for number in rig.numbers() if number is not None]
    return Outcome(len(right), len(balls), rig.ghosts > 0)


def anywhere(rig: Rig, rng: np.random.Generator) -> Outcome:
    """Run one scene, at which the head looks from one end to the other."""
    rig.show(drawn(rng, wide=True), rng, pan=rng.uniform(-0.5, 0.5), tilt=rng.uniform(0.8, 1.3))
    for pan in rng.uniform(-0.5, 0.5, 4):
        _exhaust(rig.look(0.5, pan=pan))
    return Outcome(int(not rig.ghosts), 1, rig.ghosts > 0)


def remembered(rig: Rig, rng: np.random.Generator) -> Outcome:
    """Run one scene."""
    balls, joints = drawn_in_view(rig, rng)
    rig.show(balls, rng, **joints)
    _exhaust(rig.look(1.0))
    before, kept = rig.numbers(), True
    for _ in rig.look(10.0, **_AWAY):
        kept = kept and rig.numbers() == before
    _exhaust(rig.look(3.0, **joints))
    return Outcome(int(kept and None not in before and rig.numbers() == before), 1, rig.ghosts > 0)


def removed(rig: Rig, rng: np.random.Generator) -> Outcome:
    """Run one scene."""
    balls, joints = drawn_in_view(rig, rng)
    rig.show(balls, rng, **joints)
    _exhaust(rig.look(1.0))
    _exhaust(rig.look(3.0, **_AWAY))
    number = int(rng.integers(2))
    gone, rest = balls[number], [ball for k, ball in enumerate(balls) if k != number]
    rig.backend.truth.remove(f"ball_{number}")
    since, forgotten = math.inf, math.inf
    for time in rig.look(5.0, **joints):
        since = min(since, time if rig.shows(gone) else math.inf)
        place = rig.place(gone)
        if place is None or place[1] > gone.radius:
            forgotten = min(forgotten, time)
    rig.balls = rest
    in_time = math.isfinite(since) and since <= forgotten <= since + 1.0
    return Outcome(int(in_time and None not in rig.numbers()), 1)


def carried(rig: Rig, runner: Runner, channel: str, rng: np.random.Generator) -> Outcome | None:
    """Run a scene; return ``None`` if nothing was carried to above the goal or ran away."""
    balls = _drawn_for_carrying(rig, channel, rng)
    things = {
        name: {
            "form": {"shape": "ball", "radius": ball.radius},
            "mass": 0.2,
            "color": _COLORS[ball.channel],
        }
        for name, ball in balls.items()
    }
    placed = {
        name: {"things": [name], "place": {"on": "table"} | _level(ball.centre)}
        for name, ball in balls.items()
    }
    stage = _stage(
        fixtures={"table": _TABLE},
        things=things,
        contexts={"both": {"placed": placed, "joints": _CARRYING}},
    )
    watch = _GoalWatch(rig, channel)
    runner.run(stage, int(rng.integers(2**31)), observer=EpisodeListeners(on_tick=watch))
    return Outcome(int(not watch.ran), 1) if watch.carried or watch.ran else None


def _drawn_for_carrying(rig: Rig, channel: str, rng: np.random.Generator) -> dict[str, Ball]:
    """Return two balls within reach that both cameras see whole, 10 cm or more apart."""
    while True:
        balls = []
        for each in ("hue_1", channel):
            radius = rng.uniform(0.04, 0.06)
            centre = rng.uniform(0.45, 0.65), rng.uniform(-0.35, -0.05), _TOP + radius
            balls.append(Ball(np.array(centre), radius, each))
        one, other = balls
        gap = math.dist(one.centre, other.centre) - one.radius - other.radius
        if gap > 0.1 and rig.are_whole(balls, **_CARRYING):
            return {"taken": one, "goal": other}


def _level(centre: Floats) -> dict[str, list[float]]:
    x, y, _ = centre.tolist()
    return {"x": [x, x], "y": [y, y]}


class _GoalWatch:
    """Comparison of the memory of a fixed goal with its true place, tick by tick.

    Attributes:
        carried: True if a ball was carried to above the goal.
        ran: True if the goal's remembered place has left the goal.
    """

    def __init__(self, rig: Rig, channel: str) -> None:
        self._rig, self._channel = rig, channel
        self._starts: Mapping[str, Floats] = {}
        self.carried = self.ran = False

    def __call__(self, tick: Tick) -> None:
        truth = self._rig.backend.truth
        places = {name: truth.pose(name).position.copy() for name in ("taken", "goal")}
        self._starts = self._starts or places
        shifts = {name: math.dist(places[name], self._starts[name]) for name in places}
        moved, goal = sorted(places, key=lambda name: -shifts[name])
        if shifts[goal] > 0.01 or shifts[moved] < 0.1:
            return
        self.carried = self.carried or places[moved][2] > places[goal][2] + 0.1
        memories = tick.signals.vision.instances["hue_1" if goal == "taken" else self._channel]
        known = [m.position for m in memories.memories if m.position is not None]
        errors = [math.dist(position, places[goal]) for position in known]
        held = [math.dist(position, places[moved]) for position in known]
        # A memory that is neither at the goal nor at the other ball has left one of them.
        strays = [min(e, h) for e, h in zip(errors, held, strict=True)]
        if errors:
            self.ran = self.ran or min(errors) > _RUN or max(strays) > 2 * _RUN


def _exhaust(times: Iterator[float]) -> None:
    for _ in times:
        pass


_SCENES: Mapping[str, tuple[Callable[[Rig, np.random.Generator], Outcome], float]] = {
    "in view": (in_view, 0.98),
    "anywhere": (anywhere, 1.0),
    "remembered": (remembered, 0.95),
    "removed": (removed, 1.0),
}


def measure(name: str, options: argparse.Namespace) -> dict[str, Any]:
    """Return one row of the table."""
    rig = Rig(options.backend, options.cameras)
    outcomes = list(_outcomes(rig, name, options))
    renderer = rig.renderer
    rig.close()
    right, tried = sum(each.right for each in outcomes), sum(each.tried for each in outcomes)
    ghosts, target = sum(each.ghost for each in outcomes), _target(name)
    low, high = exact_interval(right, tried)
    return {
        "scenes": name, "backend": options.backend, "images": renderer, "episodes": len(outcomes),
        "right": right, "tried": tried, "interval": [round(low, 4), round(high, 4)],
        "left_out": options.episodes - len(outcomes), "ghosts": ghosts,
        "target": target, "met": right >= target * tried and not ghosts,
    }  # fmt: skip


def _target(name: str) -> float:
    return _SCENES[name][1] if name in _SCENES else 1.0


def _outcomes(rig: Rig, name: str, options: argparse.Namespace) -> Iterator[Outcome]:
    seeds = range(options.seed, options.seed + options.episodes)
    if name in _SCENES:
        yield from (_SCENES[name][0](rig, np.random.default_rng(seed)) for seed in seeds)
        return
    with TemporaryDirectory() as folder:
        channel, goal = ("hue_7", "blue") if name == "carried, other hue" else ("hue_1", "red.2")
        runner = rig.runner(goal, Path(folder))
        for seed in seeds:
            outcome = carried(rig, runner, channel, np.random.default_rng(seed))
            if outcome is not None:
                yield outcome


def main() -> int:
    names = (*_SCENES, "carried, same hue", "carried, other hue")
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--episodes", type=int, default=200)
    parser.add_argument("--seed", type=int, default=5_000_000)
    parser.add_argument("--backend", choices=("bullet", "kinematic"), default="kinematic")
    parser.add_argument(
        "--cameras", choices=("rendered", "ideal"), help="the backend's own if none"
    )
    parser.add_argument("--only", choices=names)
    parser.add_argument("--json", action="store_true")
    options = parser.parse_args()
    missed = False
    for name in names:
        if options.only in (None, name):
            row = measure(name, options)
            missed |= not row["met"]
            print(json.dumps(row) if options.json else _line(row), flush=True)
    return int(missed)


def _line(row: dict[str, Any]) -> str:
    low, high = row["interval"]
    return (
        f"{row['scenes']:<18} {row['right']:>4} of {row['tried']:<4} "
        f"[{100 * low:5.1f}, {100 * high:5.1f}] %  target {100 * row['target']:.0f} %, "
        f"ghosts in {row['ghosts']} of {row['episodes']} scenes, {row['left_out']} left out  "
        f"{row['images']}"
    )


if __name__ == "__main__":
    sys.exit(main())
