"""Claims of success agree with the simulator's truth, on objects that nothing was trained with."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import cbdsl
from cbdsl.documents.program import PROGRAM
from cbdsl_reproduction.judges.claim_judges import (
    CLAIMS,
    NOTHING_TO_CLAIM,
    ON_OTHER_ROBOTS,
    ClaimWatch,
    Placed,
    ProgramClaim,
)
from cbdsl_reproduction.judges.claims import contexts_of, judge_claims
from cbdsl_reproduction.judges.judge import BodyChoice, EpisodeVerdict
from tests.conftest import ROOT

#: Programs that hardly ever reach their end on the chosen objects.
RARELY = {"bring_with_both", "reachtouch_bimanual", "take_with_both", "touch_remembered"}


def by_name(program: str) -> ProgramClaim:
    return next(claim for claim in CLAIMS if claim.program == program)


def test_every_shipped_program_has_a_judge_or_a_reason_to_need_none() -> None:
    shipped = {path.stem for path in (ROOT / PROGRAM.folder).glob("*.yaml")}
    judged, without = {claim.program for claim in CLAIMS}, set(NOTHING_TO_CLAIM)
    assert judged | without == shipped
    assert not judged & without
    assert all(NOTHING_TO_CLAIM.values())


@pytest.mark.parametrize(
    "program", ["bring", "bring_from_side", "bring_pinched", "bring_with_both", "deliver"]
)
def test_program_looks_back_no_more_laxly_than_its_judge(program: str) -> None:
    """Else it would claim objects that lie farther from the goal than its judge allows."""
    leads = [each.lead for each in cbdsl.load(program).program.primitives.values()]
    looks = [lead for lead in leads if lead.feedback.name.startswith("stereo.")]
    bounds = [lead.quiescence.tolerance for lead in looks if ".to." in lead.feedback.name]
    (tolerance,) = (bound for bound in bounds if bound is not None)
    judge = by_name(program).judge
    assert isinstance(judge, Placed)
    assert 0.01 <= tolerance <= judge.within


def judged(program: str, contexts: list[str], seed: int) -> list[EpisodeVerdict]:
    return list(judge_claims(by_name(program), BodyChoice("mujoco", "ideal"), [seed], contexts))


@pytest.mark.parametrize(
    ("program", "context", "claimed"),
    [
        ("deliver", "soup_can", True),
        ("bring_from_side", "wine_bottle", True),
        ("deliver", "bottle", True),
        ("deliver", "canister", False),
        ("deliver", "cereal_box", False),
        ("deliver", "carton", True),
        ("deliver", "die", True),
        ("deliver", "golf_ball", True),
        ("pinch", "block", False),
        ("deliver", "book", False),
        ("deliver", "parcel", False),
        ("grasp", "tuna_can", False),
        ("pick", "on_bench", True),
        ("pick_and_lift", "canister", False),
        ("pick_and_lift", "jar", True),
        ("pick_and_place", "mug", True),
        ("pick_and_place", "matchbox", False),
        ("reachtouch", "matchbox", False),
        ("reachtouch", "paperback", False),
        ("reachtouch", "soup_can", True),
        ("searchtrack", "hammer", True),
        ("ensure_stacked", "on_another", True),
        ("stand", "purple_box_on_blue_box", True),
        ("stand", "purple_box_on_football", False),
    ],
)
def test_claim_on_an_everyday_object_agrees_with_the_world(
    program: str, context: str, claimed: bool
) -> None:
    (verdict,) = judged(program, [context], 52_000)
    assert verdict.outcomes == {"claimed": claimed, "false claim": False}, verdict.ending


#: Contexts of the programs with many; `cb judge claims` runs all. Some claims were false in these.
SOME = {
    "bimanualtouch": ["soup_can", "matchbox", "softball"],
    "bring_pinched": ["die", "golf_ball"],
    "bring_with_both": ["parcel", "paint_can"],
    "bring": ["matchbox", "golf_ball", "tuna_can", "carton"],
    "deliver": ["matchbox", "golf_ball", "canister", "bottle"],
    "fetch": ["matchbox", "tuna_can", "paperback", "mug"],
    "grasp": ["matchbox", "soup_can", "book", "softball", "jar", "parcel"],
    "impedance": ["ball_on_drum", "can_on_slab"],
    "pick_and_lift": ["matchbox", "soup_can", "canister", "tennis_ball", "bowl", "jar"],
    "pinch": ["die", "golf_ball", "block"],
    "pick_and_place": ["matchbox", "soup_can", "canister", "tennis_ball", "bowl", "mug"],
    "reachtouch": ["matchbox", "soup_can", "book", "softball", "jar", "parcel"],
    "stand": ["purple_box_on_blue_box", "blue_box_on_football", "basketball_on_purple_box"],
    "study": ["purple_box_on_blue_box", "football_on_blue_box", "purple_box_on_basketball"],
    "stack": ["football_on_blue_box", "purple_box_on_basketball", "blue_box_on_purple_box"],
    "take": ["matchbox", "tuna_can", "bottle", "softball", "screwdriver", "canister"],
    "take_and_put_down": ["soup_can", "matchbox", "carton", "tennis_ball", "canister", "book"],
    "take_with_both": ["parcel", "medicine_ball", "play_ball"],
}


@pytest.mark.slow
@pytest.mark.parametrize(
    "program", sorted(path.stem for path in (ROOT / PROGRAM.folder).glob("*.yaml"))
)
def test_no_claim_of_a_shipped_program_is_false(program: str) -> None:
    if program in NOTHING_TO_CLAIM:
        return
    contexts = SOME.get(program) or list(contexts_of(by_name(program)))
    verdicts = judged(program, contexts, 52_100)
    is_claimed = any(verdict.outcomes["claimed"] for verdict in verdicts)
    if not is_claimed and program not in RARELY:  # a claim needs some luck with a hard program
        verdicts += judged(program, contexts, 52_101)
        assert any(verdict.outcomes["claimed"] for verdict in verdicts)
    assert [(v.context, v.ending) for v in verdicts if v.outcomes["false claim"]] == []


@pytest.mark.slow
@pytest.mark.parametrize("claim", ON_OTHER_ROBOTS, ids=lambda claim: claim.name)
def test_claim_on_another_robot_agrees_with_the_world(claim: ProgramClaim) -> None:
    body = BodyChoice("mujoco", "ideal")
    verdicts = list(judge_claims(claim, body, [52_100, 52_101], contexts_of(claim)))
    assert any(verdict.outcomes["claimed"] for verdict in verdicts)
    assert [(v.context, v.ending) for v in verdicts if v.outcomes["false claim"]] == []


class World:
    """Truth of one object and a pad that each test moves as it likes."""

    def __init__(self) -> None:
        self.places = {
            "ball": np.array([0.6, -0.2, -0.35]),
            "pad": np.array([0.6, 0.0, -0.42]),
            "table": np.array([0.6, 0.0, -0.44]),
        }
        self.held, self.loads, self.hands = True, {"table"}, ["right_hand"]

    @property
    def objects(self) -> tuple[str, ...]:
        return tuple(self.places)

    def position(self, name: str) -> NDArray[np.float64]:
        return self.places[name]

    def is_touched(self, name: str) -> bool:
        return self.held

    def touching(self, name: str) -> set[tuple[str, str]]:
        return {(hand, "thumb") for hand in self.hands} if self.held else set()

    def pressing(self, name: str) -> set[str]:
        return self.loads


def watched(*ticks: dict[str, Any]) -> ClaimWatch:
    """Return the watch of an object that is lifted, carried, released and left, with changes."""
    world = World()
    watch = ClaimWatch(world, ["ball"])  # type: ignore[arg-type]
    watch.note(None)
    lifted = {"at": (0.6, -0.2, -0.25), "pressing": set()}
    for tick in (lifted, *[{"at": (0.6, 0.0, -0.35), "pressing": {"pad"}, "held": False}] * 20):
        _show(world, tick)
        watch.note(None)
    for tick in ticks:
        _show(world, tick)
        watch.note(None)
    return watch


def _show(world: World, tick: dict[str, Any]) -> None:
    world.places["ball"] = np.array(tick.get("at", world.places["ball"]))
    world.loads = tick.get("pressing", world.loads)
    world.held = tick.get("held", world.held)
    world.hands = tick.get("hands", world.hands)


@pytest.mark.parametrize(
    ("ticks", "fault"),
    [
        ([], ""),
        ([{"held": True}], "still in the hand"),
        ([{"at": (0.6, 0.01, -0.35)}], "moving"),
        ([{"at": (0.6, 0.07, -0.35)}] * 20, "70 mm off the pad"),
        ([{"pressing": set()}] * 20, "in the air"),
    ],
)
def test_judge_of_deliver_names_each_fault(ticks: list[dict[str, Any]], fault: str) -> None:
    said = by_name("deliver").judge(watched(*ticks))
    assert said.startswith(fault) if fault else said == ""


def test_judge_of_deliver_refuses_an_object_that_was_not_lifted() -> None:
    world = World()
    watch = ClaimWatch(world, ["ball"])  # type: ignore[arg-type]
    for y in (-0.2, -0.1, 0.0, *[0.0] * 20):
        _show(world, {"at": (0.6, y, -0.35), "pressing": {"table"}, "held": False})
        watch.note(None)
    assert by_name("deliver").judge(watch) == "lifted by 0 mm"


LIFT = {"at": (0.6, -0.2, -0.2), "pressing": set(), "held": True, "hands": ["right_hand"]}
FALL = {"at": (0.6, -0.2, -0.35), "pressing": {"table"}, "held": False}
BOTH, TAKEN = {**LIFT, "hands": ["right_hand", "left_hand"]}, {**LIFT, "hands": ["left_hand"]}


@pytest.mark.parametrize(
    ("ticks", "fault"),
    [
        ([LIFT, BOTH, TAKEN], ""),
        ([TAKEN], "carried by ['left_hand']"),
        ([BOTH, TAKEN], "carried by ['left_hand']"),
        ([LIFT, FALL, TAKEN], "carried by ['left_hand']"),
        ([LIFT, FALL, {**FALL, "held": True, "hands": ["left_hand"]}], "carried by no hand"),
        ([LIFT, BOTH], "still in the right hand"),
        ([LIFT, BOTH, TAKEN, FALL], "not in the left hand"),
    ],
)
def test_judge_of_handover_demands_that_one_hand_carried_the_object_to_the_other(
    ticks: list[dict[str, Any]], fault: str
) -> None:
    world = World()
    watch = ClaimWatch(world, ["ball"])  # type: ignore[arg-type]
    watch.note(None)
    for tick in ticks:
        _show(world, tick)
        watch.note(None)
    judgement = by_name("handover").judge(watch)
    assert judgement.startswith(fault) if fault else judgement == ""


class Lower:
    """Truth of an object in the hand, which was lifted, and of a lower one of 8 cm radius."""

    objects = ("top", "base")

    def __init__(self) -> None:
        self.place, self.loads = np.array([0.6, -0.3, -0.35]), {"table"}

    def position(self, name: str) -> NDArray[np.float64]:
        return self.place if name == "top" else np.array([0.6, 0.0, -0.38])

    def half_extents(self, name: str) -> NDArray[np.float64]:
        return np.array([0.08, 0.08, 0.04])

    def is_touched(self, name: str) -> bool:
        return name == "top"

    def touching(self, name: str) -> set[tuple[str, str]]:
        return {("right_hand", "thumb")}

    def pressing(self, name: str) -> set[str]:
        return self.loads if name == "top" else {"table"}


@pytest.mark.parametrize("program", ["set_on", "impedance"])
@pytest.mark.parametrize(
    ("height", "off", "loads", "fault"),
    [
        (0.1, 0.02, {"base"}, ""),
        (0.1, 0.07, {"base"}, ""),
        (0.1, 0.10, {"base"}, "100 mm off"),
        (0.1, 0.02, set(), "borne by no object"),
        (0.1, 0.02, {"table"}, "borne by ['table']"),
        (0.1, 0.05, {"base", "table"}, "borne by ['base', 'table']"),
        (0.01, 0.02, {"base"}, "lifted by 10 mm"),
    ],
)
def test_judge_of_set_on_decides_by_the_bearing_object(
    program: str, height: float, off: float, loads: set[str], fault: str
) -> None:
    world = Lower()
    watch = ClaimWatch(world, world.objects)  # type: ignore[arg-type]
    watch.note(None)
    world.place, world.loads = world.place + np.array([0.0, 0.3 - off, height]), loads
    for _ in range(20):
        watch.note(None)
    judgement = by_name(program).judge(watch)
    assert judgement.startswith(fault) if fault else judgement == ""


class Boxes:
    """Truth of boxes of one size: lower and another support on a table, and an upper box."""

    objects = ("lower", "other", "upper")

    def __init__(self, *bearers: str) -> None:
        self.touched = set[str]()
        self.set_on(*bearers)

    def set_on(self, *bearers: str) -> None:
        """Set the upper box on other objects; it keeps its height on each of the two supports."""
        self.bearers = set(bearers)
        self._height = {("table",): -0.37, ("lower", "table"): -0.33}.get(bearers, -0.27)

    def position(self, name: str) -> NDArray[np.float64]:
        aside = {"lower": 0.0, "other": -0.3}
        if name == "table":
            return np.array([0.6, 0.0, -0.44])
        if name != "upper":
            return np.array([0.6, aside[name], -0.37])
        return np.array([0.6, aside.get(min(self.bearers), 0.1), self._height])

    def is_touched(self, name: str) -> bool:
        return name in self.touched

    def touching(self, name: str) -> set[tuple[str, str]]:
        return {("right_hand", "thumb")} if name in self.touched else set()

    def pressing(self, name: str) -> set[str]:
        return self.bearers if name == "upper" else {"table"}


@pytest.mark.parametrize(
    ("before", "after", "is_touched", "fault"),
    [
        (["lower"], ["lower"], False, ""),
        (["lower"], ["lower"], True, "touched ['upper']"),
        (["other"], ["lower"], True, ""),
        (["table"], ["lower"], True, ""),
        (["other"], ["other"], False, "the upper object is not on the lower one alone"),
        (["other"], ["lower", "other"], True, "the upper object is not on the lower one alone"),
        (["table"], ["lower", "table"], True, "the upper object is not on the lower one alone"),
    ],
)
def test_judge_of_ensure_stacked_decides_by_the_first_support_at_equal_heights(
    before: list[str], after: list[str], is_touched: bool, fault: str
) -> None:
    world = Boxes(*before)
    watch = ClaimWatch(world, world.objects)  # type: ignore[arg-type]
    watch.note(None)
    world.touched = {"upper"} if is_touched else set()
    watch.note(None)
    world.touched = set()
    world.set_on(*after)
    for _ in range(20):
        watch.note(None)
    assert by_name("ensure_stacked").judge(watch) == fault


@pytest.mark.parametrize(
    ("bearers", "fault"),
    [
        (["lower"], ""),
        (["table"], "upper is not on lower alone"),
        (["lower", "table"], "upper is not on lower alone"),
    ],
)
def test_judge_of_stacks_demands_the_desired_support(bearers: list[str], fault: str) -> None:
    world = Boxes(*bearers)
    watch = ClaimWatch(world, ["upper", "lower"])  # type: ignore[arg-type]
    for _ in range(20):
        watch.note(None)
    assert by_name("build_on").judge(watch) == fault


def test_judge_of_stacks_doubts_an_object_in_the_hand() -> None:
    world = Boxes("lower")
    world.touched = {"upper"}
    watch = ClaimWatch(world, ["upper", "lower"])  # type: ignore[arg-type]
    for _ in range(20):
        watch.note(None)
    assert by_name("stand").judge(watch) == "upper is still in the hand"


def test_judge_of_stacks_doubts_the_reversed_order() -> None:
    places = {"base": np.array([0.6, 0.0, -0.29]), "top": np.array([0.6, 0.0, -0.37])}
    places["table"] = np.array([0.6, 0.0, -0.44])
    loads = {"base": {"top"}, "top": {"base", "table"}}
    world: Any = SimpleNamespace(
        objects=("base", "top"), position=places.__getitem__, pressing=loads.__getitem__,
        is_touched=lambda name: False,
    )  # fmt: skip
    watch = ClaimWatch(world, world.objects)
    watch.note(None)
    assert by_name("stand").judge(watch) == "top is not on base alone"
