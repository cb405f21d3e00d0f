"""Judge of a guarded network: scenes, filters, disturbances, counts, and an episode of each."""

from __future__ import annotations

import math
from collections.abc import Iterable
from itertools import combinations
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cbdsl import UsageError, check
from cbdsl.api.control import Floats, Kinematics
from cbdsl.api.shipped import shipped_robot
from cbdsl.checking.stage.fixture_hulls import fixture_hull
from cbdsl.documents.stage import StageDocument
from cbdsl.extend.backend import Loads, Observation
from cbdsl.kinematics.link_clearance import too_near_at_start, with_places
from cbdsl.robot.urdf_reader import read_urdf
from cbdsl_reproduction.guarded import filters, program
from cbdsl_reproduction.guarded.disturbed_backend import DisturbedBackend
from cbdsl_reproduction.guarded.filters import (
    HAND,
    HIGH,
    LOW,
    RADII,
    barriers,
    clamped,
    random_actions,
    safe_velocity,
    signed_distance,
)
from cbdsl_reproduction.guarded.program import request_of
from cbdsl_reproduction.guarded.scene import ObstacleBox, PushScene, drawn_scene, stage_of
from cbdsl_reproduction.guarded.violations import KINDS, TrueTick, TruthBounds, Violations
from cbdsl_reproduction.judges import guarded
from cbdsl_reproduction.judges.guarded import JUDGE
from cbdsl_reproduction.judges.judge import BodyChoice

coordinate = st.floats(-1.0, 1.0).map(lambda value: round(value, 4))
point = st.tuples(coordinate, coordinate, coordinate).map(np.array)
half = st.floats(0.01, 0.3)
box = st.builds(ObstacleBox, point, st.tuples(half, half, half).map(np.array))
STAGE = StageDocument.model_validate(
    {
        "cbdsl": 1, "kind": "stage", "name": "thing_to_push", "robot": "dexter",
        "fixtures": {"table": {"form": {"shape": "box", "size": [0.6, 1.2, 0.04]},
                               "position": [0.6, 0.0, -0.44]}},
        "things": {name: {"form": {"shape": "ball", "radius": 0.05}, "mass": 0.2}
                   for name in ("block", "can")},
        "contexts": {"in_view": {"things": ["block"], "place": {"on": "table"}}},
    }
)  # fmt: skip


def unit(vector: Floats) -> Floats:
    size = float(np.linalg.norm(vector))
    return vector / size if size > 1e-3 else np.array([1.0, 0.0, 0.0])


def robot_joints(robot: Any) -> tuple[str, ...]:
    from cbdsl.robot.joints import Joints

    return tuple(Joints(robot).names)


def hand_points(kinematics: Any, model: Any, posture: Floats, tip: Any) -> Floats:
    """Return points of all shapes of the right hand in the frame of its tip, m."""
    from cbdsl.kinematics.link_tree import LinkTree
    from cbdsl.kinematics.pose import Pose
    from cbdsl.robot.joints import Joints

    robot, _ = shipped_robot("dexter")
    tree = LinkTree(model, Joints(robot), robot.base)
    tree.update(posture)
    palm, points = tree.pose(tip.link), []
    for name, body in model.bodies.items():
        if not name.startswith(("right_finger", "right_palm")):
            continue
        for shape in body.collisions:
            pose = tree.pose(name) @ Pose.at(shape.origin)
            size = np.array(shape.size, dtype=float)
            if shape.kind == "ball":
                halves = np.full(3, size[0] / math.sqrt(3.0))
            elif shape.kind == "cylinder":
                halves = np.array([size[0] / math.sqrt(2.0)] * 2 + [size[1] / 2.0])
            else:
                halves = size / 2.0
            for steps in np.ndindex(5, 5, 5):
                at = pose.position + pose.rotation @ (halves * (np.array(steps) / 2.0 - 1.0))
                points.append(palm.rotation.T @ (at - palm.position) - np.array(tip.offset))
    return np.array(points)


# Filters


def nearest_by_enumeration(velocity: Floats, rows: Floats, least: Floats) -> Floats | None:
    """Return the nearest feasible velocity among the projections on all sets of up to 3 rows."""
    best = None
    for count in range(4):
        for active in map(list, combinations(range(len(rows)), count)):
            part = rows[active]
            shift = np.linalg.pinv(part) @ (least[active] - part @ velocity) if active else 0.0
            candidate = velocity + shift
            if (rows @ candidate < least - 1e-7).any():
                continue
            if best is None or math.dist(candidate, velocity) < math.dist(best, velocity):
                best = candidate
    return best


@given(point, st.lists(st.tuples(point.map(unit), st.floats(-1.0, 0.2)), min_size=1, max_size=6))
def test_safe_velocity_is_the_nearest_one_by_enumeration(
    velocity: Floats, constraints: list[tuple[Floats, float]]
) -> None:
    rows = np.array([row for row, _ in constraints])
    least = np.array([bound for _, bound in constraints])
    safe, expected = (
        safe_velocity(velocity, rows, least),
        nearest_by_enumeration(velocity, rows, least),
    )
    if expected is None:
        assert safe == pytest.approx(np.zeros(3))
    else:
        assert (rows @ safe >= least - 1e-6).all()
        assert math.dist(safe, velocity) == pytest.approx(math.dist(expected, velocity), abs=1e-5)


@given(point, box)
def test_signed_distance_agrees_with_its_slope(place: Floats, obstacle: ObstacleBox) -> None:
    normal, distance = signed_distance(place, obstacle)
    inside = (np.abs(place - obstacle.centre) < obstacle.halves).all()
    assert (distance < 0.0) == inside or abs(distance) < 1e-9
    assert float(np.linalg.norm(normal)) == pytest.approx(1.0)
    # The nearest point of the surface is on the box, and the normal leads there.
    surface = place - distance * normal
    assert np.abs(surface - obstacle.nearest(surface)).max() < 1e-9
    _, outwards = signed_distance(place + 1e-3 * normal, obstacle)
    assert outwards == pytest.approx(distance + 1e-3, abs=1e-9)


@given(point, point, st.lists(box, max_size=3))
def test_barriers_decay_no_faster_than_their_rate(
    offset: Floats, velocity: Floats, boxes: list[ObstacleBox]
) -> None:
    palm, period = 0.5 * (LOW + HIGH) + 0.3 * offset, 1e-3
    rows, least = barriers(palm, boxes)
    if nearest_by_enumeration(np.zeros(3), rows, least) is None or (least > 0).any():
        return
    safe = safe_velocity(velocity, rows, least)
    _, after = barriers(palm + period * safe, boxes)
    # Distances to a box are convex outside of it, so that their slope bounds their loss.
    assert (-after >= -(1.0 - 5.0 * period) * least - 1e-6).all()


def test_balls_of_the_filter_cover_the_hand_as_it_pushes() -> None:
    robot, urdf = shipped_robot("dexter")
    kinematics, model = Kinematics(robot, urdf), read_urdf(urdf)
    posture = np.zeros(len(kinematics.positions))
    names = list(robot_joints(robot))
    for joint, value in zip(
        robot.effectors["right_hand"].joints, (0.0, 0.1, 0.1, 0.6), strict=True
    ):
        posture[names.index(joint)] = value
    tip = robot.effectors["right_arm"].tip
    assert tip is not None
    points = hand_points(kinematics, model, posture, tip)
    assert len(points) > 50
    # Looking down, the palm's axes y and z point backwards in the world.
    world = points * [1.0, -1.0, -1.0]
    gaps = np.linalg.norm(world[:, None] - HAND, axis=2) - RADII
    assert gaps.min(axis=1).max() < 1e-3
    assert np.linalg.norm(HAND, axis=1).max() < 0.15


@given(point, point)
def test_clamped_reference_is_in_the_workspace_and_slow(offset: Floats, way: Floats) -> None:
    palm = np.clip(0.5 * (LOW + HIGH) + offset, LOW, HIGH)
    changed = clamped(palm + way, palm, 0.0, {"pace": 2.0})
    assert ((changed >= LOW - 1e-9) & (changed <= HIGH + 1e-9)).all()
    assert 2.0 * math.dist(changed, palm) <= 0.25 + 1e-9
    inside = np.clip(palm + 0.01 * way, LOW, HIGH)
    assert clamped(inside, palm, 0.0, {"pace": 1.0}) == pytest.approx(inside)


def test_random_actions_replace_a_share_and_hold_for_a_period() -> None:
    options = {"share": 0.1, "speed": 0.2, "seed": 7.0}
    palm, reference = np.zeros(3), np.array([0.0, 0.0, 1.0])
    times = np.arange(20_000) / 200.0
    changed = np.array([random_actions(reference, palm, t, options) for t in times])
    by_action = changed.reshape(-1, 10, 3)
    assert (by_action == by_action[:, :1]).all()
    others = (by_action[:, 0] != reference).any(axis=1)
    assert 0.07 < others.mean() < 0.13  # of 2,000: 3 standard deviations are 0.02
    assert np.linalg.norm(by_action[others][:, 0], axis=1).max() <= 0.2
    assert not np.array_equal(
        changed, [random_actions(reference, palm, t, {**options, "seed": 8.0}) for t in times]
    )


# Scenes


def test_obstacles_of_scenes_leave_the_way_of_the_object_free() -> None:
    counts = set()
    for seed in range(300):
        scene = drawn_scene(seed)
        counts.add(len(scene.obstacles))
        for name, obstacle in scene.obstacles.items():
            assert abs(obstacle.centre[0] - scene.place[0]) - obstacle.halves[0] >= 0.11
            others = [each for other, each in scene.obstacles.items() if other != name]
            assert all(obstacle.is_apart(each, 0.019) for each in others)
    assert counts == {1, 2, 3}


def test_no_link_starts_within_the_clearance_of_an_obstacle() -> None:
    robot, urdf = shipped_robot("dexter")
    model = read_urdf(urdf)
    for seed in range(40):
        scene = drawn_scene(seed)
        stage = StageDocument.model_validate(stage_of(scene, STAGE, is_clean=False))
        hulls = {name: fixture_hull(name, stage) for name in scene.obstacles}
        assert not too_near_at_start(with_places(robot, hulls), model, 0.01), seed


def test_clean_stage_has_no_obstacle_and_no_camera_error() -> None:
    stage = StageDocument.model_validate(stage_of(drawn_scene(3), STAGE, is_clean=True))
    assert set(stage.fixtures) == {"table"}
    assert stage.disturbance.camera_position == 0.0


# Counts

BOUNDS = TruthBounds(np.full(2, -1.0), np.full(2, 1.0), np.full(2, 0.5), LOW, HIGH)
contact = st.builds(
    SimpleNamespace,
    link=st.sampled_from(["palm", "forearm"]),
    other=st.sampled_from(["block", "table", "obstacle_1", "torso"]),
    force=point.map(lambda force: 8.0 * force),
).map(lambda made: SimpleNamespace(**vars(made), is_link=made.other == "torso"))
pair = st.tuples(st.floats(-1.2, 1.2), st.floats(-1.2, 1.2)).map(np.array)
moment = st.builds(
    TrueTick, pair, pair, st.none() | point, st.lists(contact, max_size=4).map(tuple)
)


def violated(each: TrueTick) -> Iterable[str]:
    """Yield the kinds of violations of a moment, component by component."""
    others = [contact.other for contact in each.contacts]
    if "obstacle_1" in others:
        yield "obstacle"
    if "table" in others:
        yield "table"
    if "torso" in others:
        yield "link"
    total = [0.0, 0.0, 0.0]
    for contact in each.contacts:
        if contact.other != "torso":
            total = [a + float(b) for a, b in zip(total, contact.force, strict=True)]
    if math.hypot(*total) > 8.0:
        yield "force"
    if each.palm is not None and any(
        not low - 1e-3 <= x <= high + 1e-3
        for x, low, high in zip(each.palm, LOW, HIGH, strict=True)
    ):
        yield "keep-out"
    if any(abs(x) > 1.001 for x in each.positions):
        yield "joint limit"
    if any(abs(v) > 0.51 for v in each.velocities):
        yield "speed limit"


@given(st.lists(moment, max_size=6))
def test_violations_count_the_ticks_of_each_kind(moments: list[TrueTick]) -> None:
    violations = Violations(BOUNDS, ["block"])
    for each in moments:
        violations.note(each)
    kinds = [kind for each in moments for kind in violated(each)]
    assert violations.ticks == {kind: kinds.count(kind) for kind in KINDS}
    assert bool(violations.touched) == bool({"obstacle", "table", "link"} & set(kinds))


# Disturbances


class _World:
    """Backend that records pushes, and whose sensors read 0."""

    renderer, control_period, deadline = "nothing", 1 / 60, None

    def __init__(self) -> None:
        self.truth = self
        self.pushed: list[dict[str, Floats]] = []
        self.now: dict[str, Floats] = {}

    def push(self, link: str, force: Floats) -> None:
        self.now[link] = force

    def reset(self, stage: Any, context: Any, rng: np.random.Generator, channels: Any) -> str:
        self.drawn = rng.random(3).tolist()
        return "context"

    def observe(self) -> Observation:
        loads = Loads((("hand", "1"),), np.zeros((1, 6)))
        zero = np.zeros(4)
        return Observation(time=0.0, positions=zero, velocities=zero, loads=loads, images={})

    def step(self) -> None:
        self.pushed.append(dict(self.now))


def test_disturbed_backend_pushes_and_leaves_the_draws_of_the_world() -> None:
    world, stage = _World(), STAGE
    backend = DisturbedBackend(world, ["forearm", "palm"])
    backend.reset(stage, None, np.random.default_rng(5))
    assert world.drawn == np.random.default_rng(5).random(3).tolist()
    assert np.array_equal(backend.observe().positions, backend.observe().positions)
    for _ in range(600):
        backend.step()
    assert len(backend.pushes) == 4
    assert all(5.0 <= np.linalg.norm(push.force) <= 20.0 for push in backend.pushes)
    for tick, now in enumerate(world.pushed):
        for link in ("forearm", "palm"):
            active = [
                push.force
                for push in backend.pushes
                if push.link == link and push.begin <= tick / 60 < push.begin + 0.2
            ]
            assert now[link] == pytest.approx(np.sum(active, axis=0) if active else np.zeros(3))
    before = backend.pushes
    backend.reset(stage, None, np.random.default_rng(5))
    assert [each.begin for each in backend.pushes] == [each.begin for each in before]


def test_noise_stays_the_same_until_the_next_step() -> None:
    backend = DisturbedBackend(_World(), ["palm"])
    backend.reset(STAGE, None, np.random.default_rng(0))
    seen = []
    for _ in range(500):
        assert backend.observe() is backend.observe()
        seen.append(backend.observe())
        backend.step()
    spread = {
        "positions": np.std([each.positions for each in seen]),
        "velocities": np.std([each.velocities for each in seen]),
        "forces": np.std([each.loads["hand", "1"][:3] for each in seen]),
    }
    assert spread == pytest.approx({"positions": 1e-3, "velocities": 1e-2, "forces": 0.2}, rel=0.1)
    assert not np.any([each.loads["hand", "1"][3:] for each in seen])


# The judge


@pytest.mark.parametrize("missing", ["cbdsl_onnx", "onnxruntime"])
def test_missing_package_is_named_with_its_extra(
    monkeypatch: pytest.MonkeyPatch, missing: str
) -> None:
    monkeypatch.setattr(guarded, "find_spec", lambda name: None if name == missing else object())
    condition = next(each for each in JUDGE.conditions if each.name == "CBF-QP")
    with pytest.raises(UsageError) as refused:
        next(JUDGE.measure(condition, JUDGE.body, [0]))
    assert str(refused.value) == (
        f"the judge 'guarded' needs {missing}: pip install 'cbdsl-reproduction[guarded]'"
    )


def test_another_backend_is_refused() -> None:
    with pytest.raises(UsageError, match="MuJoCo"):
        next(JUDGE.measure(JUDGE.conditions[0], BodyChoice("kinematic", "ideal"), [0]))


@pytest.mark.slow
@pytest.mark.parametrize("condition", JUDGE.conditions, ids=lambda each: each.name)
def test_written_documents_of_each_condition_have_no_findings(
    condition: Any, tmp_path: Path
) -> None:
    pytest.importorskip("onnxruntime")
    setting = guarded._SETTINGS[condition.name]
    request = request_of(setting, 7, tmp_path)
    assert [str(finding) for finding in check(*sorted(tmp_path.glob("*.yaml")))] == []
    guards = request.program.guards
    assert (guards.clearance is not None) == setting.is_guarded
    known = set(drawn_scene(7).obstacles)
    assert set(request.stage.fixtures) == {"table", *([] if setting.is_clean else known)}
    if setting.is_guarded:
        assert set(guards.fixtures) == set(request.stage.fixtures)
    modified = {
        name: [modifier.name for modifier in primitive.lead.modifiers]
        for name, primitive in request.program.primitives.items()
    }
    expected = [] if setting.is_clean else ["random_actions"]
    assert modified["policy"] == expected + ([setting.filter] if setting.filter else [])


@pytest.mark.slow
@pytest.mark.parametrize("condition", JUDGE.conditions, ids=lambda each: each.name)
def test_episode_of_each_condition_is_judged(condition: Any, tmp_path: Path) -> None:
    pytest.importorskip("onnxruntime")
    (verdict,) = JUDGE.measure(condition, JUDGE.body, [20_004])
    assert set(condition.aims) == set(verdict.outcomes)
    assert "success lost" in verdict.outcomes and verdict.seed == 20_004
    assert verdict.outcomes["success"] == ("added_s" in verdict.measures)
    if "guarded" in condition.name:
        assert not any(verdict.outcomes[kind] for kind in KINDS), verdict.ending


# Boxes in the way of the hand, and of the forearm above it.
POST = ObstacleBox(np.array([0.33, -0.52, -0.29]), np.array([0.03, 0.03, 0.13]))
BEAM = ObstacleBox(np.array([0.40, -0.64, 0.12]), np.array([0.03, 0.03, 0.06]))


@pytest.mark.slow
@pytest.mark.parametrize(
    ("obstacle", "condition", "is_touched"),
    [
        (POST, "bare", True),
        (POST, "clamped", True),
        (POST, "CBF-QP", False),
        (POST, "guarded", False),
        (BEAM, "bare", True),
        (BEAM, "CBF-QP", True),
        (BEAM, "guarded", False),
    ],
)
def test_filter_spares_the_hand_alone_and_guards_spare_all_links(
    monkeypatch: pytest.MonkeyPatch, obstacle: ObstacleBox, condition: str, is_touched: bool
) -> None:
    pytest.importorskip("onnxruntime")
    scene = PushScene("block", (0.52, -0.22, 0.0), {"obstacle_1": obstacle})
    for module in (filters, program):
        monkeypatch.setattr(module, "drawn_scene", lambda seed: scene)
    ended = guarded._run(guarded._SETTINGS[condition], 0, JUDGE.body)
    touched = [pair for pair in ended.violations.touched if "obstacle" in pair]
    assert bool(touched) is is_touched, (touched, ended.result.ending)
    assert bool(ended.violations.ticks["obstacle"]) is is_touched
    if obstacle is BEAM:
        assert all("_link_" in pair for pair in touched), touched
