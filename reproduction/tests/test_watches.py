"""Watches of judges: verdicts on worlds that contradict the robot, or miss an aim."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import cbdsl
from cbdsl_reproduction.judges import (
    both_hands,
    calibration,
    ensure_stacked,
    everyday,
    find_by_touch,
    gripper,
    handover,
    holding,
    hover_follow,
    pick_and_place,
    success_rates,
    touch_table,
)
from cbdsl_reproduction.judges.judge import BodyChoice, EpisodeVerdict, Judge
from cbdsl_reproduction.judges.watch import Watch

Floats = NDArray[np.float64]

RIGHT = frozenset(("right_hand", f"finger_{k}") for k in range(3))
LEFT = frozenset(("left_hand", f"finger_{k}") for k in range(3))


class World:
    """Truth that each test changes as it likes; bodies and links without a place are at zero."""

    def __init__(self, *objects: str) -> None:
        self.objects = objects
        self.places: dict[str, tuple[float, float, float]] = {}
        self.axes: dict[str, Floats] = {}
        self.velocities: dict[str, tuple[float, float, float]] = {}
        self.cells: dict[str, frozenset[tuple[str, str]]] = {}
        self.loads: dict[str, set[str]] = {}
        self.force = 0.0

    def position(self, name: str) -> Floats:
        return np.array(self.places.get(name, (0.0, 0.0, 0.0)))

    def rotation(self, name: str) -> Floats:
        return self.axes.get(name, np.eye(3))

    link_position, link_rotation = position, rotation

    def velocity(self, name: str) -> Floats:
        return np.array(self.velocities.get(name, (0.0, 0.0, 0.0)))

    def touching(self, name: str) -> frozenset[tuple[str, str]]:
        return self.cells.get(name, frozenset())

    def is_touched(self, name: str) -> bool:
        return bool(self.touching(name))

    def pressing(self, name: str) -> set[str]:
        return self.loads.get(name, set())

    def half_extents(self, name: str) -> Floats:
        return np.full(3, 0.05)

    def fingertip_forces(self) -> dict[tuple[str, str], Floats]:
        return {cell: np.array([0.0, 0.0, self.force]) for cell in RIGHT | LEFT}


def watch_of(judge: Judge, watch: Callable[..., Watch], world: World, condition: int = 0) -> Any:
    """Return the watch of one of a judge's conditions in a world."""
    tip = SimpleNamespace(link="palm", offset=(0.0, 0.0, 0.0))
    arms = {f"{side}_arm": SimpleNamespace(tip=tip) for side in ("right", "left")}
    stage = SimpleNamespace(fixtures={"table": None}, things={"ball": None})
    request = SimpleNamespace(robot=SimpleNamespace(effectors=arms), stage=stage)
    simulated = SimpleNamespace(truth=world, robot=SimpleNamespace(request=request))
    return watch(simulated, judge.conditions[condition], BodyChoice("bullet", None))


def concluded(watch: Any, outcome: str = "success") -> EpisodeVerdict:
    """Return the verdict on an episode that the robot takes for a success."""
    result = cbdsl.EpisodeResult(
        "", "", "", 1, rewarded=True, predicates=("X", "1"), actions=(), ticks=1, sim_seconds=1.0,
        wall_seconds=1.0, renderer="", ending="", outcome=outcome,
    )  # fmt: skip
    verdict: EpisodeVerdict = watch.conclude(result)
    return verdict


def reward(program: str, action: str) -> Any:
    """Return a rewarded transition."""
    return cbdsl.Transition(program, 0, 1.0, "0", action, "1", 1, 1, (action,))


@pytest.mark.parametrize(("fingertips", "is_false"), [(3, False), (2, True), (0, True)])
def test_success_rates_doubt_a_reward_without_three_contacts(
    fingertips: int, is_false: bool
) -> None:
    world = World("ball", "table")
    world.places["ball"] = (0.5, 0.0, 0.1)
    world.cells["ball"] = frozenset(sorted(RIGHT)[:fingertips])
    verdict = concluded(watch_of(success_rates.JUDGE, success_rates._Contacts, world))
    assert verdict.outcomes["rewarded without three contacts"] == is_false
    assert not verdict.outcomes["fallen"]
    world.places["ball"] = (0.5, 0.0, -0.1)
    verdict = concluded(watch_of(success_rates.JUDGE, success_rates._Contacts, world))
    assert verdict.outcomes["fallen"]


@pytest.mark.parametrize(
    ("ticks", "is_false"),
    [([RIGHT] * 6, False), ([RIGHT, frozenset()] * 3, False), ([LEFT] * 6, True),
     ([RIGHT] * 9 + [frozenset()] * 4, True)],
)  # fmt: skip
def test_touch_table_doubts_a_reward_without_presses_of_its_hand(
    ticks: list[frozenset[tuple[str, str]]], is_false: bool
) -> None:
    world = World("table")
    watch = watch_of(touch_table.JUDGE, touch_table._Presses, world)
    for cells in ticks:
        world.cells["table"] = cells
        watch.note(None)
    assert concluded(watch).outcomes["rewarded without contact"] == is_false


@pytest.mark.parametrize("is_touched", [True, False])
def test_find_by_touch_doubts_a_report_without_contact(is_touched: bool) -> None:
    world = World("ball", "table")
    world.cells = {"ball": RIGHT} if is_touched else {"table": RIGHT}
    verdict = concluded(watch_of(find_by_touch.JUDGE, find_by_touch._Found, world))
    expected = {"found": is_touched, "reported without contact": not is_touched}
    assert verdict.outcomes == expected


@pytest.mark.parametrize(("fingertips", "is_false"), [(3, False), (2, True)])
def test_calibration_doubts_a_reward_without_three_contacts(
    fingertips: int, is_false: bool
) -> None:
    world = World("ball", "table")
    world.cells["ball"] = frozenset(sorted(RIGHT)[:fingertips])
    verdict = concluded(watch_of(calibration.JUDGE, calibration._RewardedContacts, world))
    assert verdict.outcomes == {"rewarded": True, "rewarded without contact": is_false}


def _tilted(degrees: float) -> Floats:
    """Return axes that are tilted about x."""
    cosine, sine = math.cos(math.radians(degrees)), math.sin(math.radians(degrees))
    return np.array([[1.0, 0.0, 0.0], [0.0, cosine, -sine], [0.0, sine, cosine]])


@pytest.mark.parametrize(
    ("place", "tilt", "is_placed"),
    [
        ((0.49, 0.294, 0.05), 0.0, True),
        ((0.49, 0.309, 0.05), 90.0, True),
        ((0.49, 0.319, 0.05), 0.0, False),
        ((0.49, 0.294, 0.06), 0.0, False),
        ((0.49, 0.294, 0.05), 12.0, False),
    ],
)
def test_gripper_counts_a_cube_flat_at_its_place(
    place: tuple[float, float, float], tilt: float, is_placed: bool
) -> None:
    world = World("cube")
    world.places["cube"], world.axes["cube"] = place, _tilted(tilt)
    verdict = concluded(watch_of(gripper.JUDGE, gripper._Cube, world))
    assert verdict.outcomes == {"placed": is_placed}


_CUBE = 1  # condition of pick_and_place
_PARCEL = [condition.name for condition in everyday.JUDGE.conditions].index("parcel")


@pytest.mark.parametrize(
    ("change", "is_placed"),
    [
        ({}, True),
        ({"places": {"cube": (0.021, 0.0, 0.0)}}, False),
        ({"axes": {"cube": _tilted(11.0)}}, False),
        ({"velocities": {"cube": (0.0, 0.02, 0.0)}}, False),
        ({"cells": {"cube": RIGHT}}, False),
        ({"loads": {}}, False),
    ],
)
def test_pick_and_place_counts_an_object_left_on_the_pad(
    change: Mapping[str, Any], is_placed: bool
) -> None:
    world = World("cube", "pad")
    world.loads["cube"] = {"pad"}
    watch = watch_of(pick_and_place.JUDGE, pick_and_place._Pad, world, _CUBE)
    watch.note(None)
    vars(world).update(change)
    assert concluded(watch).outcomes["placed"] == is_placed
    assert not concluded(watch, outcome="failure").outcomes["placed"]


# The transition is in the tick after the last noted one, which has not been noted yet.
@pytest.mark.parametrize(("ticks", "is_false"), [(5, False), (6, True)])
def test_pick_and_place_doubts_a_reward_after_the_last_contact(ticks: int, is_false: bool) -> None:
    world = World("cube", "pad")
    world.loads["cube"] = {"pad"}
    watch = watch_of(pick_and_place.JUDGE, pick_and_place._Pad, world, _CUBE)
    watch.note(None)
    world.loads.clear()
    for _ in range(ticks):
        watch.note(None)
    watch.hear(reward("pick_and_place", "place"))
    assert concluded(watch).outcomes["rewarded without contact"] == is_false


def test_pick_and_place_believes_a_reward_in_the_tick_of_the_first_contact() -> None:
    world = World("cube", "pad")
    watch = watch_of(pick_and_place.JUDGE, pick_and_place._Pad, world, _CUBE)
    watch.note(None)
    world.loads["cube"] = {"pad"}
    watch.hear(reward("pick_and_place", "place"))
    assert not concluded(watch).outcomes["rewarded without contact"]


@pytest.mark.parametrize(
    ("drift", "tilt", "kept", "steady"),
    [(0.0, 0.0, True, True), (0.009, 0.0, True, False), (0.0, 6.0, True, False),
     (0.061, 0.0, False, False)],
)  # fmt: skip
def test_holding_counts_objects_that_stay_in_the_hand(
    drift: float, tilt: float, kept: bool, steady: bool
) -> None:
    world = World("ball")
    watch = watch_of(holding.JUDGE, holding._Hold, world)
    watch.hear(reward("grasp", "grip"))
    world.places = {"palm": (0.0, 0.0, 0.2), "ball": (drift, 0.0, 0.2)}
    world.axes["ball"] = _tilted(tilt)
    world.force = 15.1
    watch.note(None)
    expected = {"kept": kept, "steady": steady, "force above 15 N": True}
    assert concluded(watch).outcomes == expected


def test_holding_counts_no_object_without_a_grasp() -> None:
    verdict = concluded(watch_of(holding.JUDGE, holding._Hold, World("ball")))
    assert not verdict.outcomes["kept"]
    assert verdict.measures.keys() == {"force_N"}


@pytest.mark.parametrize("first", [0.0, 90.0])
@pytest.mark.parametrize(("turn", "is_back"), [(0.0, True), (9.0, False)])
def test_delivery_counts_an_object_as_put_back_in_its_first_attitude(
    first: float, turn: float, is_back: bool
) -> None:
    world = World("parcel")
    watch = watch_of(everyday.JUDGE, everyday._Delivery, world, _PARCEL)
    joints = SimpleNamespace(of=lambda arm: [0])
    observation = SimpleNamespace(positions=np.zeros(1))
    tick = SimpleNamespace(signals=SimpleNamespace(joints=joints), observation=observation)
    world.axes["parcel"] = _tilted(first)
    watch.note(tick)
    observation.positions = np.ones(1)
    world.axes["parcel"] = _tilted(first + turn)
    watch.note(tick)
    assert concluded(watch, outcome="failure").outcomes["put back"] == is_back


@pytest.mark.parametrize(("turn", "before_motion"), [(0.0, True), (0.01, True), (0.1, False)])
def test_delivery_counts_a_refusal_before_the_arms_move_alone(
    turn: float, before_motion: bool
) -> None:
    watch = watch_of(everyday.JUDGE, everyday._Delivery, World("parcel"), _PARCEL)
    joints = SimpleNamespace(of=lambda arm: [0])
    observation = SimpleNamespace(positions=np.zeros(1))
    tick = SimpleNamespace(signals=SimpleNamespace(joints=joints), observation=observation)
    watch.note(tick)
    observation.positions = np.full(1, turn)
    watch.note(tick)
    # An arm that has come back has moved.
    observation.positions = np.zeros(1)
    watch.note(tick)
    assert concluded(watch, outcome="failure").outcomes["refused before motion"] == before_motion


@pytest.mark.parametrize(
    ("cells", "is_false"), [(RIGHT | LEFT, False), (RIGHT, True), (frozenset(), True)]
)
def test_watch_of_both_hands_doubts_a_reward_of_one_hand(
    cells: frozenset[tuple[str, str]], is_false: bool
) -> None:
    world = World("ball")
    watch = watch_of(both_hands.JUDGE, both_hands._Hands, world)
    world.cells["ball"] = cells
    watch.note(None)
    watch.hear(reward("take_with_both", "squeeze"))
    world.places["ball"] = (0.0, 0.0, 0.06)
    outcomes = concluded(watch).outcomes
    assert outcomes["rewarded without contact"] == is_false
    assert outcomes["lifted"] == (not is_false)
    world.loads["ball"] = {"table"}
    assert not concluded(watch).outcomes["lifted"]


@pytest.mark.parametrize(("ticks", "is_false"), [(0, False), (5, False), (6, True), (None, False)])
def test_watch_of_both_hands_doubts_a_reward_after_the_last_contact(
    ticks: int | None, is_false: bool
) -> None:
    """Leave the object for some ticks, or touch it first in the tick of the reward."""
    world = World("ball")
    watch = watch_of(both_hands.JUDGE, both_hands._Hands, world)
    world.cells["ball"] = RIGHT | LEFT if ticks is not None else frozenset()
    watch.note(None)
    world.cells["ball"] = RIGHT | LEFT if ticks is None else frozenset()
    for _ in range(ticks or 0):
        watch.note(None)
    watch.hear(reward("take_with_both", "squeeze"))
    assert concluded(watch).outcomes["rewarded without contact"] == is_false


@pytest.mark.parametrize(
    ("cells", "palm", "slip", "is_passed"),
    [
        (LEFT, 0.3, 0.0, True),
        (LEFT | RIGHT, 0.3, 0.0, False),
        (LEFT, 0.1, 0.0, False),
        (LEFT, 0.3, 0.04, False),
    ],
)
def test_handover_counts_an_object_in_the_other_hand_alone(
    cells: frozenset[tuple[str, str]], palm: float, slip: float, is_passed: bool
) -> None:
    world = World("ball")
    world.places["right_palm"] = (0.0, palm, 0.0)
    watch = watch_of(handover.JUDGE, handover._Passed, world)
    world.cells["ball"] = RIGHT
    for _ in range(6):
        watch.note(None)
    world.cells["ball"] = cells
    watch.note(None)
    world.places["ball"] = (slip, 0.0, 0.0)
    watch.note(None)
    expected = {"handed over": is_passed, "reported wrongly": not is_passed}
    assert concluded(watch).outcomes == expected


@pytest.mark.parametrize(
    ("before", "is_passed"),
    [
        ([(RIGHT, "")] * 6, True),
        ([(RIGHT, ""), (frozenset(), "")] * 6, True),
        ([], False),
        ([(RIGHT, "table")] * 20, False),
        ([(RIGHT, "")] * 20 + [(LEFT, "table")], False),
        ([(LEFT | RIGHT, "")] * 20, False),
    ],
)
def test_handover_demands_that_the_giver_carried_the_object(
    before: list[tuple[frozenset[tuple[str, str]], str]], is_passed: bool
) -> None:
    world = World("ball", "table")
    world.places["right_palm"] = (0.0, 0.3, 0.0)
    watch = watch_of(handover.JUDGE, handover._Passed, world)
    for cells, support in [*before, *[(LEFT, "")] * 60]:
        world.cells["ball"], world.loads["ball"] = cells, {support} - {""}
        watch.note(None)
    assert concluded(watch).outcomes["handed over"] == is_passed


@pytest.mark.parametrize(
    ("before", "after", "touched", "outcome", "stands", "is_false"),
    [
        ("lower", "lower", False, "success", True, False),
        ("lower", "lower", True, "success", False, True),
        ("table", "lower", True, "success", True, False),
        ("table", "table", True, "success", False, True),
        ("table", "lower", True, "failure", False, False),
    ],
)
def test_ensure_stacked_counts_a_pair_that_stands_or_was_stacked(
    before: str, after: str, touched: bool, outcome: str, stands: bool, is_false: bool
) -> None:
    world = World("lower", "upper", "table")
    world.places = {"upper": (0.6, 0.0, 0.2), "lower": (0.6, 0.0, 0.1)}
    watch = watch_of(ensure_stacked.JUDGE, ensure_stacked._Pair, world)
    for bearer, cells in ((before, frozenset()), (before, RIGHT if touched else frozenset()),
                          *[(after, frozenset())] * 15):  # fmt: skip
        world.loads["upper"], world.cells["upper"] = {bearer}, frozenset(cells)
        watch.note(None)
    expected = {"stands": stands, "false success": is_false}
    assert concluded(watch, outcome).outcomes == expected


@pytest.mark.parametrize(("near", "is_followed"), [(1.0, True), (0.96, True), (0.94, False)])
def test_hover_follow_counts_the_share_of_time_above_the_ball(
    near: float, is_followed: bool
) -> None:
    world = World("ball", "table")
    watch = watch_of(hover_follow.JUDGE, hover_follow._Above, world)
    for tick in range(2400):
        time = tick / 60
        is_near = (time - 6.0) / 30.0 < near
        world.places["palm"] = (0.0, 0.0, 0.22 if is_near else 0.26)
        watch.note(SimpleNamespace(observation=SimpleNamespace(time=time)))
    assert concluded(watch).outcomes["followed"] == is_followed
