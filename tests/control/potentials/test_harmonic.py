"""The harmonic potential: displacements that a spring can follow, around obstacles that move."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import pytest

from cbdsl.control.law import Law, LawSettings
from cbdsl.control.level import Level
from cbdsl.control.potential import Potential
from cbdsl.control.potential_registry import build
from cbdsl.control.potentials import harmonic
from cbdsl.control.potentials.field import HarmonicField, NoPathError
from cbdsl.control.potentials.grid import Grid
from cbdsl.control.potentials.harmonic import Harmonic
from cbdsl.control.setting import Setting
from cbdsl.kinematics.obstacle import Obstacle
from cbdsl.numeric.arrays import Floats
from cbdsl.program.controller import Controller, Field, Quiescence
from cbdsl.types.resource import EffectorConfiguration, Origin, Resource
from cbdsl.types.resource_type import configuration
from tests.control.chain import Chain
from tests.control.evaluation import Evaluation, Signal, evaluate
from tests.control.scenes import SCENES, Scene

SCALE = 0.2


def potential(scene: Scene) -> Potential:
    n = len(scene.goal)
    return Harmonic(np.zeros(n), np.ones(n), scene.grid.spacing, SCALE).potential


def prepared(
    potential: Potential,
    value: Floats,
    goal: Floats,
    obstacles: tuple[Obstacle, ...] = (),
    jacobian: Floats | None = None,
) -> Evaluation:
    """Solve the field, and then evaluate the potential."""
    assert potential.prepare is not None
    potential.prepare(value, goal, obstacles, potential.parameters)
    rows = np.eye(len(value)) if jacobian is None else jacobian
    return evaluate(potential, Signal(value, rows), goal)


@pytest.fixture
def solved(monkeypatch: pytest.MonkeyPatch) -> list[HarmonicField]:
    """Return a list that collects the fields that are solved."""
    fields: list[HarmonicField] = []

    class Counted(HarmonicField):
        def __init__(self, *args: object) -> None:
            super().__init__(*args)  # type: ignore[arg-type]
            fields.append(self)

    monkeypatch.setattr(harmonic, "HarmonicField", Counted)
    return fields


@pytest.mark.parametrize("name", SCENES)
def test_displacements_are_bounded_and_half_of_them_is_the_step(
    name: str, rng: np.random.Generator
) -> None:
    scene = SCENES[name]
    law = potential(scene)
    for point in (*scene.starts(10, rng), *rng.uniform(-0.2, 1.2, (5, len(scene.goal)))):
        found = prepared(law, point, scene.goal, scene.obstacles)
        left = np.linalg.norm(scene.goal - point)
        assert 0.0 < np.linalg.norm(found.residual) <= min(SCALE, left) * (1 + 1e-12)
        np.testing.assert_array_equal(found.step, 0.5 * found.residual)
        np.testing.assert_array_equal(found.jacobian, np.eye(len(point)))
        assert np.isfinite(found.phi) and found.phi > 0.0
    at_goal = prepared(law, scene.goal, scene.goal, scene.obstacles)
    assert at_goal.phi == 0.0
    assert not at_goal.residual.any()


@pytest.mark.parametrize("name", SCENES)
def test_steps_lower_phi_and_end_at_the_goal(name: str, rng: np.random.Generator) -> None:
    scene = SCENES[name]
    law = potential(scene)
    for point in scene.starts(2, rng):
        phis = []
        for _ in range(4000):
            found = prepared(law, point, scene.goal, scene.obstacles)
            phis.append(found.phi)
            # The speed is bounded by 0.3 cells a tick.
            length = np.linalg.norm(found.step)
            point = point + found.step * min(1.0, 0.3 * scene.grid.spacing / max(length, 1e-12))
            if found.phi < 1e-9:
                break
        assert np.linalg.norm(point - scene.goal) < 1e-6
        assert (np.diff(phis) < 0).mean() > 0.9


def walk(law: Potential, start: Floats, goal: Floats, box: Obstacle) -> Iterator[Floats]:
    """Yield joint positions under the control law, from the measured posture, rad."""
    bounds = Law(np.full(2, -1.5), np.full(2, 1.5), LawSettings(joint_step=0.02))
    q = start
    for _ in range(600):
        found = prepared(law, q, goal, (box,))
        q = q + bounds.solve([Level("look", found.jacobian, 0.2 * found.step)], q).displacement
        yield q


def test_two_joints_go_round_a_box_in_their_space() -> None:
    box = Obstacle("glare", np.array([-0.3, -1.5]), np.array([0.3, 0.5]))
    head = Resource("head", configuration(2), Origin.PROPRIOCEPTION, EffectorConfiguration("h"))
    law = build(
        Controller(
            "look", "harmonic", head, None, head, (), (), False, 2.0, None, None,
            Quiescence(1e-3, 0.3), field=Field(None, None, 0.05, 0.5, 0.1, ()),
        ),
        Setting(np.full(2, -1.5), np.full(2, 1.5), 2, 2),
    )  # fmt: skip
    assert law.size == 2
    start, goal = np.array([-1.0, -0.8]), np.array([1.0, -0.7])
    path = list(walk(law, start, goal, box))
    assert np.linalg.norm(path[-1] - goal) < 1e-4
    # The straight line crosses the box; the way round keeps the clearance.
    assert box.distance(0.5 * (start + goal)) <= 0.0
    assert min(box.distance(q) for q in path) > 0.1


def test_tip_goes_round_a_ball(rng: np.random.Generator) -> None:
    chain = Chain.random(7, rng)
    start, q = chain.signal("position", np.zeros(7)).value, np.zeros(7)
    goal = chain.signal("position", rng.uniform(-0.4, 0.4, 7)).value
    ball = Obstacle.sphere("ball", 0.5 * (start + goal), 0.25 * float(np.linalg.norm(goal - start)))
    lower, upper = np.minimum(start, goal) - 0.6, np.maximum(start, goal) + 0.6
    law = Harmonic(lower, upper, 0.05, 0.1).potential
    arm = Law(np.full(7, -3.0), np.full(7, 3.0), LawSettings(joint_step=0.05))
    nearest = np.inf
    for _ in range(800):
        tip = chain.signal("position", q)
        found = prepared(law, tip.value, goal, (ball,), tip.jacobian)
        q = q + arm.solve([Level("tip", found.jacobian, 0.2 * found.step)], q).displacement
        nearest = min(nearest, ball.distance(tip.value))
    assert np.linalg.norm(chain.signal("position", q).value - goal) < 1e-3
    assert nearest > 0.0


def test_field_is_solved_again_only_after_a_motion(solved: list[HarmonicField]) -> None:
    scene = SCENES["cluttered cube"]
    law, spacing = potential(scene), scene.grid.spacing
    point = np.full(3, 0.1)
    shift = np.array([spacing, 0.0, 0.0])
    first, *others = scene.obstacles

    def moved(by: Floats) -> tuple[Obstacle, ...]:
        return (first._replace(lower=first.lower + by, upper=first.upper + by), *others)

    counts = []
    for goal, obstacles in (
        (scene.goal, scene.obstacles),
        (scene.goal + 0.1 * shift, scene.obstacles),
        (scene.goal, moved(0.2 * shift)),
        (scene.goal, moved(0.3 * shift)),
        (scene.goal, (first, *others[1:])),
        (scene.goal + 1.5 * shift, (first, *others[1:])),
    ):
        prepared(law, point, goal, obstacles)
        counts.append(len(solved))
    assert counts == [1, 1, 1, 2, 3, 4]


def test_goal_that_moves_is_followed_without_a_jump() -> None:
    scene = SCENES["empty square"]
    law, point = potential(scene), scene.goal.copy()
    for tick in range(300):
        goal = scene.goal + 0.1 * np.sin(0.02 * tick) * np.array([1.0, -1.0])
        found = prepared(law, point, goal)
        point = point + 0.5 * found.step
        assert np.linalg.norm(point - goal) < 0.02


def test_clearance_widens_obstacles() -> None:
    scene = SCENES["empty square"]
    ball = Obstacle.sphere("ball", scene.goal + 0.2, 0.1)
    narrow, wide = (
        Harmonic(np.zeros(2), np.ones(2), 0.05, SCALE, clearance).potential
        for clearance in (0.1, 0.2)
    )
    prepared(narrow, np.full(2, 0.1), scene.goal, (ball,))
    with pytest.raises(NoPathError, match="the goal is inside ball"):
        prepared(wide, np.full(2, 0.1), scene.goal, (ball,))


def test_unsolved_field_has_no_potential() -> None:
    law = potential(SCENES["empty square"])
    assert np.isnan(evaluate(law, Signal(np.zeros(2), np.eye(2)), np.ones(2)).phi)


def test_way_out_of_an_obstacle_lowers_phi() -> None:
    """Otherwise a motion that begins inside of one would count as being at rest."""
    goal, box = np.array([0.8, 0.8]), Obstacle("box", np.array([0.1, 0.1]), np.array([0.5, 0.5]))
    field = Harmonic(np.zeros(2), np.ones(2), 0.02, SCALE)
    parameters = np.full(3, np.nan)
    phis = []
    for x in (0.40, 0.43, 0.46, 0.49, 0.55, 0.6):
        field.prepare(np.array([x, 0.3]), goal, (box,), parameters)
        phis.append(float(parameters[0]))
        assert parameters[1] > 0.0  # outwards, and then on
    assert phis == sorted(phis, reverse=True)
    assert phis[0] - phis[2] == pytest.approx(0.06 / 0.02)


def test_way_out_leads_to_the_nearest_vertex_from_any_point() -> None:
    grid = Grid.between(np.zeros(3), np.array([1.0, 0.8, 0.6]), 0.05)
    obstacles = (Obstacle.sphere("ball", np.array([0.5, 0.4, 0.3]), 0.22),)
    goal = np.array([0.9, 0.7, 0.5])
    field = HarmonicField(grid, obstacles, goal)
    vertices = grid.lower + grid.spacing * np.argwhere(field.u > 0.0)
    rng = np.random.default_rng(0)
    depths = []
    for scatter in (0.1, 0.5, 3.0):
        for point in np.array([0.5, 0.4, 0.3]) + scatter * rng.standard_normal((40, 3)):
            slope = field.slope(point, goal)
            if slope.closeness > 0.0:
                continue
            distances = np.linalg.norm(vertices - point, axis=1)
            assert slope.depth * grid.spacing == pytest.approx(distances.min())
            arrived = point + slope.depth * grid.spacing * slope.direction
            assert np.linalg.norm(vertices - arrived, axis=1).min() < 1e-9
            depths.append(slope.depth)
    assert len(depths) > 60 and min(depths) < 5 and max(depths) > 100


@pytest.mark.parametrize("bounded", [False, True])
def test_workspace_is_the_stated_one_or_the_joint_limits(bounded: bool) -> None:
    scene = SCENES["empty square"]
    box = ((0.0, 0.0), (1.0, 1.0)) if bounded else (None, None)
    limits = (np.full(2, 0.3), np.full(2, 0.6)) if bounded else (np.zeros(2), np.ones(2))
    law = built(Field(*box, scene.grid.spacing, SCALE, 0.0, ()), *limits)
    point = np.full(2, 0.1)
    found, wanted = (prepared(each, point, scene.goal) for each in (law, potential(scene)))
    np.testing.assert_allclose(found.residual, wanted.residual)
    assert found.phi == pytest.approx(wanted.phi)


def test_harmonic_potential_needs_a_field() -> None:
    with pytest.raises(ValueError, match="needs a field"):
        built(None, np.zeros(2), np.ones(2))
    far = Field(None, None, 0.05, SCALE, 0.0, ())
    with pytest.raises(ValueError, match="finite bounds"):
        built(far, np.full(2, -np.inf), np.full(2, np.inf))


def built(field: Field | None, lower: Floats, upper: Floats) -> Potential:
    """Return the potential of two joints with limits, rad."""
    arm = Resource("arm", configuration(2), Origin.PROPRIOCEPTION, EffectorConfiguration("arm"))
    own = Controller(
        "go", "harmonic", arm, None, arm, (), (), False, 2.0, None, None, Quiescence(1e-3, 0.3),
        field=field,
    )  # fmt: skip
    return build(own, Setting(lower, upper, 2, 2))


@pytest.mark.parametrize("turns", [-2, 0, 1])
def test_position_of_a_joint_without_limits_counts_in_one_turn(turns: int) -> None:
    lower, upper = np.full(2, -np.pi), np.full(2, np.pi)
    law = Harmonic(lower, upper, 0.1, SCALE, circular=np.array([True, False])).potential
    assert law.prepare is not None
    shifted = np.array([2.0 * np.pi * turns, 0.0])
    start, goal, found = np.array([-1.0, 0.5]), np.array([1.5, -0.5]), []
    for value, target in ((start, goal), (start + shifted, goal), (start, goal + shifted)):
        parameters = np.empty(3)
        law.prepare(value, target, (), parameters)
        found.append(parameters)
    assert found[1] == pytest.approx(found[0]) and found[2] == pytest.approx(found[0])


def test_position_of_a_joint_with_limits_beyond_the_field_has_no_path() -> None:
    law = Harmonic(np.full(2, -np.pi), np.full(2, np.pi), 0.1, SCALE).potential
    assert law.prepare is not None
    with pytest.raises(NoPathError):
        law.prepare(np.zeros(2), np.array([2.0 * np.pi, 0.0]), (), np.empty(3))
