"""``transport_hand``: the hand on its way around a wall, in a synthetic world and with physics."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from cbdsl.backends.bullet.backend import BulletBackend
from cbdsl.documents.robot import RobotDocument
from cbdsl.documents.stage import StageDocument
from cbdsl.kinematics.kinematics import Kinematics
from cbdsl.kinematics.obstacle import Obstacle
from cbdsl.numeric.arrays import Floats
from cbdsl.program.checked import CheckedProgram
from cbdsl.program.controller import Box, Controller, Field
from cbdsl.runtime.episode import Runner
from cbdsl.runtime.episode_observer import EpisodeListeners
from cbdsl.runtime.tick import Tick
from cbdsl.types.resource import Resource
from tests.conftest import Checked
from tests.runtime.conftest import Play
from tests.runtime.synthetic import Ball, World


def transport_of(program: CheckedProgram) -> Controller:
    (found,) = {
        controller
        for action in program.actions
        if action.composition is not None
        for primitive in action.composition.primitives
        for controller in primitive.controllers
        if controller.potential == "harmonic"
    }
    return found


def field_of(program: CheckedProgram) -> tuple[Field, Obstacle]:
    """Return the field, and the wall in it without the clearance."""
    field = transport_of(program).field
    assert field is not None
    (wall,) = field.obstacles
    assert isinstance(wall, Box)
    return field, Obstacle(wall.name, np.array(wall.lower), np.array(wall.upper))


class Path:
    """Where the point went that the hand is transported by: in front of the palm."""

    def __init__(self, program: CheckedProgram) -> None:
        standoff = transport_of(program).standoff
        assert standoff is not None
        self._standoff, self._palm = standoff, transport_of(program).feedback
        goal = transport_of(program).reference
        assert isinstance(goal, Resource)
        self._goal = goal
        self.points: list[Floats] = []
        self.distance = np.inf

    def note(self, tick: Tick) -> None:
        goal = tick.signals.read(self._goal)
        if goal is None:
            return
        reach = goal.radius + self._standoff.clearance
        forward = min(max(reach, self._standoff.least), self._standoff.most)
        palm, frame = tick.signals.read(self._palm), tick.signals.kinematics.frame("right_palm")
        assert palm is not None
        tip = palm.value + forward * frame.rotation[:, 2]
        self.points.append(tip)
        self.distance = float(np.linalg.norm(tip - goal.value))


def wall_crossed(path: Path, wall: Obstacle) -> bool:
    """Return True if the straight way from the first to the last point meets the wall."""
    first, last = path.points[0], path.points[-1]
    return any(wall.distance(first + s * (last - first)) <= 0.0 for s in np.linspace(0, 1, 100))


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(500, 506))
def test_hand_goes_round_the_wall_and_arrives(
    seed: int,
    dexter: RobotDocument,
    kinematics: Kinematics,
    checked: Checked,
    stage: Callable[[str], StageDocument],
    bullet: BulletBackend,
) -> None:
    program = checked("transport_hand")
    field, wall = field_of(program)
    path, touched = Path(program), []

    def note(tick: Tick) -> None:
        path.note(tick)
        touched.append(bullet.truth.touched("wall"))

    result = Runner(dexter, kinematics, program, bullet).run(
        stage("wall_right"), seed, observer=EpisodeListeners(on_tick=note)
    )
    assert result.predicates[-1] == "X1", result.ending
    assert path.distance < 0.005
    assert min(wall.distance(point) for point in path.points) > field.clearance - field.spacing
    assert not any(touched)
    assert wall_crossed(path, wall.grown(field.clearance))


def test_transport_hand_arrives_in_a_synthetic_world(checked: Checked, play: Play) -> None:
    program = checked("transport_hand")
    field, wall = field_of(program)
    path = Path(program)
    ball = World(Ball(np.array([0.62, -0.15, -0.35])))
    played = play(program, lambda rng: ball, watch=path.note)
    assert played.result.predicates[-1] == "X1", played.result.ending
    assert "transport came to rest 0.0 cm from stereo.sat_10" in played.result.ending
    assert path.distance < 0.005
    assert min(wall.distance(point) for point in path.points) > field.clearance - field.spacing


def test_object_inside_the_wall_is_reported_without_a_path(checked: Checked, play: Play) -> None:
    program = checked("transport_hand")
    ball = World(Ball(np.array([0.40, -0.36, -0.18])))
    played = play(program, lambda rng: ball)
    assert "transport had no way: the goal is inside box 1 of the field" in played.result.ending


AROUND = """
controllers:
  move:
    potential: harmonic
    reference: [68 cm, -5 cm, -20 cm]
    feedback: right_arm.position
    effector: right_arm
    field:
      lower: [0 cm, -80 cm, -42 cm]
      upper: [90 cm, 40 cm, 30 cm]
      spacing: 3 cm
      clearance: 6 cm
      obstacles: [stereo.sat_10, {center: left_arm.position, radius: 20 cm}]
actions: [move]
policy: {X: move, "0": move}
"""


def test_seen_obstacle_is_avoided(written: Callable[..., CheckedProgram], play: Play) -> None:
    program = written(AROUND)
    ball = Ball(np.array([0.5, -0.2, -0.25]))
    points: list[Floats] = []

    def note(tick: Tick) -> None:
        (run,) = tick.run.runs
        tip = tick.signals.read(run.controller.feedback)
        assert tip is not None
        points.append(tip.value)

    played = play(program, lambda rng: World(ball), watch=note)
    assert played.result.predicates[-1] == "1", played.result.ending
    goal = np.array([0.68, -0.05, -0.2])
    assert np.linalg.norm(points[-1] - goal) < 0.005
    seen = Obstacle.sphere("ball", ball.position, ball.radius)
    assert min(seen.distance(point) for point in points) > 0.06 - 0.03
    shares = np.linspace(0.0, 1.0, 50)
    assert min(seen.distance(points[0] + s * (goal - points[0])) for s in shares) < 0.0
