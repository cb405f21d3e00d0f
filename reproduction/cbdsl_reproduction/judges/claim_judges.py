"""Judges of claims by the simulator's truth, one for each kind of claim.

A judge returns the reason why a claim is false at the end of an episode, or an empty text if it is
true. ``CLAIMS`` lists the programs with their stages, whose objects appear in no training as far as
there are such stages. ``NOTHING_TO_CLAIM`` has the reason for each other program.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from cbdsl import Truth

Floats = NDArray[np.float64]

# An object is lifted, at rest and raised from here on, m and m/s.
LIFTED, STILL, RAISED = 0.02, 0.01, 0.05
# Ticks of 1/60 s over which a speed is averaged, and before a claim in which a contact counts.
WHILE, BEFORE = 12, 6
# Names of objects in contexts of stacks, in the desired order from below.
FROM_BELOW = ("base", "lower", "middle", "upper", "top")
# Largest angle from the optical axis of a camera in the middle of whose image an object is, rad.
MIDDLE = math.radians(10)
# Largest distance of a hand's tip from the middle of the object that it reached for, m, beyond the
# distance from the tip at which it stops.
REACHED, STANDOFF = 0.05, 0.14


class ClaimWatch:
    """Truth about the objects of one episode.

    Args:
        truth: Ground truth of the world.
        things: Names of the objects that the stage has.
    """

    def __init__(self, truth: Truth, things: Iterable[str]) -> None:
        self._truth, self._all = truth, set(things)
        self._tracks: dict[str, list[Floats]] = {}
        self._first_bearers: dict[str, set[str]] = {}
        self._pressed: dict[str, dict[str, int]] = {}
        self._carriers: dict[str, dict[str, None]] = {}
        self._touched: dict[str, None] = {}
        self._count = 0
        self._tick: Any = None

    def note(self, tick: Any) -> None:
        """Take in a tick."""
        self._tick, self._count = tick, self._count + 1
        for name in self._all.intersection(self._truth.objects):
            if name not in self._tracks:
                self._first_bearers[name] = self.bearers(name)
            self._tracks.setdefault(name, []).append(self._truth.position(name))
            self._note_contacts(name)

    def _note_contacts(self, name: str) -> None:
        """Take in the contacts of an object with other objects and with the robot."""
        pressing, is_touched = self._truth.pressing(name), self._truth.is_touched(name)
        pressed, carriers = self._pressed.setdefault(name, {}), self._carriers.setdefault(name, {})
        pressed.update(dict.fromkeys(pressing, self._count))
        if pressing:
            carriers.clear()
        elif is_touched and self.height(name) > LIFTED:
            hands = {hand for hand, _ in self._truth.touching(name)}
            if len(hands) == 1:
                carriers.setdefault(hands.pop())
        if is_touched:
            self._touched.setdefault(name)

    @property
    def things(self) -> list[str]:
        """Names of the objects that were in the world."""
        return list(self._tracks)

    @property
    def ever_touched(self) -> list[str]:
        """Names of the objects that the robot has touched, in the order of the first touches."""
        return list(self._touched)

    def lift(self, name: str) -> float:
        """Return the largest height of an object above its first place, m."""
        track = np.array(self._tracks[name])
        return float((track[:, 2] - track[0, 2]).max())

    def height(self, name: str) -> float:
        """Return the height of an object above its first place at the end, m."""
        track = self._tracks[name]
        return float(track[-1][2] - track[0][2])

    def shift(self, name: str) -> float:
        """Return the distance of an object from its first place at the end, m."""
        track = self._tracks[name]
        return math.dist(track[0], track[-1])

    def speed(self, name: str) -> float:
        """Return the mean speed of an object over the last ticks, m/s."""
        # Objects at rest jitter in single ticks, so that the displacement over 0.2 s counts.
        track = self._tracks[name][-WHILE:]
        return 60.0 * math.dist(track[0], track[-1]) / max(len(track) - 1, 1)

    def distance(self, name: str, goal: str) -> float:
        """Return the distance of an object from a goal on the level, m."""
        place = self._truth.position(goal)
        return math.dist(self._tracks[name][-1][:2], place[:2])

    def is_held(self, name: str) -> bool:
        """Return whether the robot touches an object."""
        return bool(self._truth.is_touched(name))

    def fingers(self, name: str, hand: str) -> int:
        """Return the number of a hand's fingertips on an object, or on a fixture."""
        return sum(cell[0] == hand for cell in self._truth.touching(name))

    def is_borne(self, name: str) -> bool:
        """Return whether another object bore an object a moment ago."""
        return bool(self.borne_by(name))

    def borne_by(self, name: str) -> set[str]:
        """Return the names of the objects that pressed on an object a moment ago."""
        # Contacts of stiff bodies come and go between ticks, so that one within 0.1 s counts.
        pressed = self._pressed[name].items()
        return {other for other, count in pressed if self._count - count <= BEFORE}

    def carriers(self, name: str) -> list[str]:
        """Return the hands that bore an object alone since another object last bore it.

        They are in the order of the first ticks.
        """
        return list(self._carriers[name])

    def is_above(self, name: str, base: str) -> bool:
        """Return whether the centre of an object is above another one."""
        # The circle within the base's footprint does not depend on its turn.
        return self.distance(name, base) < float(min(self._truth.half_extents(base)[:2]))

    def bearers(self, name: str) -> set[str]:
        """Return the names of the objects that press on an object and have lower centres."""
        height = self._truth.position(name)[2]
        pressing = self._truth.pressing(name)
        return {other for other in pressing if self._truth.position(other)[2] < height}

    def first_bearers(self, name: str) -> set[str]:
        """Return the bearers of an object at its first tick."""
        return self._first_bearers[name]

    def aside(self, name: str) -> float:
        """Return the smallest angle of an object from the optical axis of a camera, rad."""
        signals, place = self._tick.signals, self._truth.position(name)
        signals.kinematics.place()
        angles = []
        for camera in signals.robot.cameras.values():
            frame = signals.kinematics.frame(camera.link)
            ray = place - frame.position
            angles.append(math.acos(float(frame.rotation[:, 0] @ ray) / float(np.linalg.norm(ray))))
        return min(angles)

    def reach(self, name: str, arm: str) -> float:
        """Return the distance of an arm's tip from an object, m."""
        tip = self._tick.signals.tips.point(arm).position
        return math.dist(tip, self._truth.position(name))


Judge = Callable[[ClaimWatch], str]


@dataclass(frozen=True)
class Placed:
    """Judge that the object rests on another one, near the pad, after it was lifted.

    Attributes:
        within: Largest distance from the pad's centre, m, which is the program's own tolerance.
        is_released: True if the program also claims that the hand is off, and the object at rest.
    """

    within: float
    is_released: bool = True

    def __call__(self, watch: ClaimWatch) -> str:
        """Return why the claim is false; empty if it is true."""
        (name,) = watch.things
        if self.is_released and watch.is_held(name):
            return "still in the hand"
        if self.is_released and watch.speed(name) > STILL:
            return f"moving at {1e3 * watch.speed(name):.0f} mm/s"
        # An object that was pushed onto the pad was not
        # carried, so that its largest height counts as well.
        if watch.lift(name) < LIFTED:
            return f"lifted by {1e3 * watch.lift(name):.0f} mm"
        off = watch.distance(name, "pad")
        if off > self.within:
            return f"{1e3 * off:.0f} mm off the pad"
        return "" if watch.is_borne(name) else "in the air"


def put_down(watch: ClaimWatch) -> str:
    """Judge that the object was lifted, released, and rests on something."""
    (name,) = watch.things
    if watch.is_held(name):
        return "still in the hand"
    if watch.lift(name) < LIFTED:
        return f"lifted by {1e3 * watch.lift(name):.0f} mm"
    if watch.speed(name) > STILL:
        return f"moving at {1e3 * watch.speed(name):.0f} mm/s"
    return "" if watch.is_borne(name) else "in the air"


def stands(watch: ClaimWatch) -> str:
    """Judge that each object rests on the desired one and on nothing else."""
    # The stage's names give the order; heights at the end would accept a reversed stack.
    for below, name in pairwise(sorted(watch.things, key=FROM_BELOW.index)):
        if watch.is_held(name):
            return f"{name} is still in the hand"
        if watch.speed(name) > STILL:
            return f"{name} moves at {1e3 * watch.speed(name):.0f} mm/s"
        if watch.bearers(name) != {below}:
            return f"{name} is not on {below} alone"
    return ""


def left_alone_or_stacked(watch: ClaimWatch) -> str:
    """Judge that the upper object rests on the lower one, untouched if it stood there before."""
    lower, upper = "lower", "upper"
    if watch.bearers(upper) != {lower} or watch.is_held(upper):
        return "the upper object is not on the lower one alone"
    if watch.speed(upper) > STILL:
        return f"the upper object moves at {1e3 * watch.speed(upper):.0f} mm/s"
    # Heights do not show it: an object may come from a support that is as high as the lower one.
    stood = lower in watch.first_bearers(upper)
    return f"touched {watch.ever_touched}" if stood and watch.ever_touched else ""


def set_on(watch: ClaimWatch) -> str:
    """Judge that the lower object alone bears the upper one, which was lifted onto it."""
    top, base = "top", "base"
    if watch.lift(top) < LIFTED:
        return f"lifted by {1e3 * watch.lift(top):.0f} mm"
    # The hand may still bear a part of the load.
    if watch.borne_by(top) != {base}:
        return f"borne by {sorted(watch.borne_by(top)) or 'no object'}"
    # An object that leans against the side of the lower one is not on it.
    off = watch.distance(top, base)
    return "" if watch.is_above(top, base) else f"{1e3 * off:.0f} mm off the lower object"


def raised(watch: ClaimWatch) -> str:
    """Judge that an object is in a hand, and off the table."""
    heights = [watch.height(name) for name in watch.things if watch.is_held(name)]
    if not heights:
        return "not in the hand"
    height = max(heights)
    return "" if height > RAISED else f"raised by {1e3 * height:.0f} mm"


def touched(watch: ClaimWatch) -> str:
    """Judge that the robot touches an object of the stage."""
    return "" if any(map(watch.is_held, watch.things)) else "touches no object"


def grasped(watch: ClaimWatch) -> str:
    """Judge that all fingertips of one hand are on one object."""
    most = max(watch.fingers(n, h) for n in watch.things for h in ("left_hand", "right_hand"))
    return "" if most == 3 else f"{most} fingertips on the object"


def between_hands(watch: ClaimWatch) -> str:
    """Judge that both hands are on one object."""
    for name in watch.things:
        if all(watch.fingers(name, hand) for hand in ("left_hand", "right_hand")):
            return ""
    return "not between both hands"


def in_left_hand(watch: ClaimWatch) -> str:
    """Judge that the left hand alone holds the object, which the right hand carried to it."""
    (name,) = watch.things
    if watch.fingers(name, "right_hand"):
        return "still in the right hand"
    if not watch.fingers(name, "left_hand"):
        return "not in the left hand"
    # An object that fell between the hands, and that the left one then took, was not handed over.
    if watch.carriers(name) != ["right_hand", "left_hand"]:
        return f"carried by {watch.carriers(name) or 'no hand'} since it left its support"
    return raised(watch)


def other_touched(watch: ClaimWatch) -> str:
    """Judge that the robot touches another object than its first one."""
    now = [name for name in watch.things if watch.is_held(name)]
    return "" if set(now) - set(watch.ever_touched[:1]) else f"touches {now or 'no object'}"


def on_table(watch: ClaimWatch) -> str:
    """Judge that fingertips of the right hand are on the table."""
    return "" if watch.fingers("table", "right_hand") else "no fingertip on the table"


def looked_at(watch: ClaimWatch) -> str:
    """Judge that an object is in the middle of an image."""
    angle = min(map(watch.aside, watch.things))
    return "" if angle < MIDDLE else f"{math.degrees(angle):.0f} deg aside"


def untouched(watch: ClaimWatch) -> str:
    """Judge that the robot touches no object."""
    now = [name for name in watch.things if watch.is_held(name)]
    return f"touches {now}" if now else ""


def reached(watch: ClaimWatch) -> str:
    """Judge that the tip of the right arm is at an object, as near as its standoff allows."""
    off = min(watch.reach(name, "right_arm") for name in watch.things)
    return "" if off < STANDOFF + REACHED else f"{1e3 * off:.0f} mm off the object"


class ProgramClaim(NamedTuple):
    """Program on a stage, and the judge of its claims.

    Attributes:
        program, stage: Names of the documents.
        judge: Function that returns why a claim is false, empty if it is true.
        contexts: Contexts of the stage; all if empty.
        values: Values of the program's parameters, by context.
        robot: Name of the robot, for programs over roles; that of the stage if empty.
    """

    program: str
    stage: str
    judge: Judge
    contexts: tuple[str, ...] = ()
    values: Callable[[str], Mapping[str, str]] = lambda context: {}
    robot: str = ""

    @property
    def name(self) -> str:
        """Name of the condition: the program, and its robot if that is another one."""
        return f"{self.program} on {self.robot}" if self.robot else self.program


_CHANNELS = {"blue_box": "blue", "purple_box": "hue_9", "basketball": "red", "football": "green"}


def _to_left(_: str) -> Mapping[str, str]:
    """Return the receiving arm of a handover."""
    return {"arm": "left_arm"}


def _red(_: str) -> Mapping[str, str]:
    """Return the channel of everyday objects."""
    return {"feature": "red"}


def _pair(context: str) -> Mapping[str, str]:
    """Return channels of two objects of the stage ``stacking``."""
    upper, _, lower = context.partition("_on_")
    return {"feature": _CHANNELS[upper], "goal": _CHANNELS[lower]}


def _on_stack(context: str) -> Mapping[str, str]:
    """Return the channel of the object that is set on a stack of the stage ``stack_and_more``."""
    return {"feature": "red" if context.startswith("red_box") else "green"}


def _three(_: str) -> Mapping[str, str]:
    """Return channels of three objects of the stage ``stacks_of_three``."""
    return {"feature": "red", "middle": "green", "goal": "blue"}


_PAIRS = tuple(f"{a}_on_{b}" for a in _CHANNELS for b in _CHANNELS if a != b)
_SET = ("can_on_slab", "box_on_drum", "ball_on_drum", "can_on_ball")
_LARGE = ("parcel", "medicine_ball", "play_ball", "cereal_box", "paint_can", "tray")
_SMALL = ("die", "golf_ball", "block")
_DARK = ("dark",)
_TO_GIVE = ("ball_right", "cube_right", "cylinder_right")

#: Claims of the shipped programs, as far as possible about objects that no training stage has.
CLAIMS: Sequence[ProgramClaim] = (
    ProgramClaim("bimanualgrab", "box_between_hands", between_hands),
    ProgramClaim("bimanualinspect", "box_between_hands", between_hands),
    ProgramClaim("bimanualtouch", "everyday_objects", between_hands, values=_red),
    ProgramClaim("bring", "everyday_objects", Placed(0.05, is_released=False)),
    ProgramClaim("bring_from_side", "tall_objects", Placed(0.04)),
    ProgramClaim("bring_pinched", "everyday_objects", Placed(0.04), _SMALL),
    ProgramClaim("bring_with_both", "everyday_objects", Placed(0.05), _LARGE),
    ProgramClaim("build_on", "stack_and_more", stands, values=_on_stack),
    ProgramClaim("deliver", "everyday_objects", Placed(0.04)),
    ProgramClaim("ensure_stacked", "stacked_or_not", left_alone_or_stacked),
    ProgramClaim("fetch", "everyday_objects", Placed(0.05, is_released=False)),
    ProgramClaim("find_by_touch", "lights_out", touched, _DARK),
    ProgramClaim("find_the_other", "two_red_balls", other_touched),
    ProgramClaim("grasp", "everyday_objects", grasped),
    ProgramClaim("handover", "things_to_give", in_left_hand, _TO_GIVE, _to_left),
    ProgramClaim("impedance", "other_pairs", set_on, _SET),
    ProgramClaim("let_go", "large_on_table", untouched),
    ProgramClaim("notice", "something_new", looked_at, ("before_the_window", "elsewhere")),
    ProgramClaim("pick", "cube_on_bench", put_down),
    ProgramClaim("pick_and_lift", "everyday_objects", raised),
    ProgramClaim("pick_and_place", "everyday_objects", Placed(0.03, is_released=False)),
    ProgramClaim("pinch", "everyday_objects", raised, _SMALL),
    ProgramClaim("press_and_slide", "absent", on_table),
    ProgramClaim("reach", "everyday_objects", reached, values=_red),
    ProgramClaim("reachtouch", "everyday_objects", grasped, values=_red),
    ProgramClaim("reachtouch_bimanual", "everyday_objects", between_hands, _LARGE, _red),
    ProgramClaim("searchtrack", "everyday_objects", looked_at, values=_red),
    ProgramClaim("set_on", "other_pairs", set_on, _SET),
    ProgramClaim("stack", "stacking", stands, _PAIRS, _pair),
    ProgramClaim("stack_three", "stacks_of_three", stands),
    ProgramClaim("stand", "stacking", stands, _PAIRS, _pair),
    ProgramClaim("stand_three", "stacks_of_three", stands, values=_three),
    ProgramClaim("study", "stacking", stands, _PAIRS, _pair),
    ProgramClaim("tactileprobe", "held_right", grasped),
    ProgramClaim("take", "everyday_objects", grasped),
    ProgramClaim("take_and_put_down", "everyday_objects", put_down, values=_red),
    ProgramClaim("take_from_side", "tall_objects", grasped),
    ProgramClaim("take_with_both", "everyday_objects", raised, _LARGE),
    ProgramClaim("touch_remembered", "lights_out", touched, _DARK),
    ProgramClaim("touch_table", "bare_table", on_table),
    ProgramClaim("transport_hand", "wall_right", reached),
    ProgramClaim("visualinspect", "spotted_right", looked_at),
    ProgramClaim("watch_for_motion", "shaken", looked_at),
)

#: Claims of programs over roles on other robots.
ON_OTHER_ROBOTS: Sequence[ProgramClaim] = (
    ProgramClaim("pick_and_lift", "cube_on_bench", raised, robot="panda"),
    ProgramClaim("pick_and_place", "cube_and_pad", Placed(0.03, is_released=False), robot="panda"),
    ProgramClaim("stack", "cubes_to_stack", stands, robot="panda"),
    ProgramClaim("take_and_put_down", "cube_on_bench", put_down, values=_red, robot="panda"),
)

#: Claims by the names of their programs.
CLAIM_OF: Mapping[str, ProgramClaim] = {claim.program: claim for claim in CLAIMS}

#: Reason for each shipped program whose end claims nothing about the world.
NOTHING_TO_CLAIM: Mapping[str, str] = {
    "hover_follow": "follows until its time is over; comes to no end of its own",
    "poise": "moves an arm without sensors; ends at a posture",
    "posture": "moves an arm to a posture",
    "push": "claims a force, which tests/runtime/test_force_programs.py judges",
    "put_back": "begins with something held; judged as the end of fetch with a heavy can",
    "put_down": "begins with something held; judged as the end of take_and_put_down",
    "put_down_from_side": "begins with something held; judged as the end of bring_from_side",
    "put_down_with_both": "begins with something held; judged as the end of bring_with_both",
    "see": "waits until an object is seen; moves nothing",
    "show_ball": "shows a ball to cb calibrate; has neither reward nor success",
    "survey": "looks how large an object is; moves the head alone",
    "survey_for_both": "looks how large an object is; moves the head alone",
    "twist": "claims a torque, which tests/runtime/test_force_programs.py judges",
}
