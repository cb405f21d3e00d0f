"""History of a recorded episode: courses of controllers, signals and contacts, read only."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from cbdsl.extend.diagnosis import (
    FLAGS,
    HOLDERS,
    SIGHT,
    Floats,
    Recorded,
    read_links,
    turned,
)

Mask = NDArray[np.bool_]

#: Ranks of causes: a halt explains any end, and a mere end is a cause only without an event.
HALT, EVENT, END = range(3)


#: Ticks in which a joint that follows reaches its reference.
AGES = 3
#: Force of a load cell above which a hand is in contact, N.
CONTACT = 0.3
#: Kinds of ``SIGHT`` in which the images show an object.
SHOWN = ("seen", "several")
# Distance of an object from the fingers below which it may touch the hand beside its cells, m.
_NEAR = 0.25
# Lag of a joint that pushes, and motion of one that is stopped, as shares of the largest lead, and
# the time of that motion, s.
_PUSHES, _STILL, _STOPPED = 0.5, 0.25, 0.3


class FailureCause(NamedTuple):
    """Cause of a failure, as recorded.

    Attributes:
        kind: Name of the kind.
        tick: First tick in which it shows.
        sentence: The cause as a clause, with its numbers.
        numbers: The same numbers in SI, by name.
        times: Number of its occurrences.
        rank: ``HALT``, ``EVENT`` or ``END``; causes of a lower rank come first at any time.
    """

    kind: str
    tick: int
    sentence: str
    numbers: Mapping[str, float] = {}
    times: int = 1
    rank: int = EVENT


class ControllerCourse(NamedTuple):
    """Recorded values of one controller by tick, with its triple.

    Attributes:
        name: Name, qualified by the uses of programs.
        member: Member that it determines; empty if it determines none.
        feedback, reference, base, effector, unit, requires, potential: Texts as in a recording's
            triple.
        letters: Predicate by tick, shape (T,).
        errors: Norm of the residual by tick, shape (T,), NaN while undefined.
        acts: True while it is a level of the stack, shape (T,).
        flags: Facts of ``FLAGS`` by tick, shape (T, flags).
        shares: Achieved share of the requested displacement by tick, shape (T,).
        holders: Index of the holder by tick as in a recording, shape (T,).
        ranks: Number of its free task coordinates by tick, shape (T,).
        singular_values: Smallest singular values by tick, shape (T,).
    """

    name: str
    member: str
    feedback: str
    reference: str
    base: str
    effector: str
    unit: str
    requires: str
    potential: str
    letters: NDArray[np.str_]
    errors: Floats
    acts: Mask
    flags: Mask
    shares: Floats
    holders: NDArray[np.int16]
    ranks: NDArray[np.int8]
    singular_values: Floats

    def flag(self, name: str) -> Mask:
        """Return the ticks in which a fact of ``FLAGS`` holds, shape (T,)."""
        return self.flags[:, FLAGS.index(name)]

    def rests_after(self, tick: int) -> bool:
        """Return whether it came to rest at its target after a tick."""
        arrived = (self.letters == "1") & ~self.flag("stuck")
        return bool(arrived[tick + 1 :].any())

    @property
    def defined(self) -> Mask:
        """True while it is active and its error is defined, shape (T,)."""
        defined: Mask = np.isin(self.letters, ("0", "1")) & ~np.isnan(self.errors)
        return defined

    @property
    def program(self) -> str:
        """Use of the program that it belongs to, with a dot behind; empty for the main one."""
        return self.name[: self.name.rfind(".") + 1]

    @property
    def grasps(self) -> bool:
        """True if the hands that it moves feel the forces that it controls.

        Two arms press on an object between them by the net forces of their hands.
        """
        is_own = self.feedback.split(".")[0] == self.effector.split(".")[0]
        return self.unit == "N" and (is_own or self.feedback.endswith(".net_forces"))

    @property
    def is_bound(self) -> bool:
        """True if it only bounds a value, which other levels may keep."""
        return self.potential in ("at_least", "at_most")

    @property
    def is_shared(self) -> bool:
        """True if it controls the net forces of hands, by which they hold an object together."""
        return self.unit == "N" and self.feedback.endswith(".net_forces")

    @property
    def hand(self) -> str:
        """Name of the effector that it moves, without its part."""
        return self.effector.split(".")[0]

    @property
    def strength(self) -> float:
        """Reference force along the normals of the fingertips, N; NaN for another reference."""
        force, along, _ = self.reference.partition(" N along ")
        return float(force) if along else float("nan")

    def measure(self, error: float) -> str:
        """Return an error in its reported unit."""
        factor, unit = {"m": (100.0, "cm"), "rad": (180.0 / np.pi, "deg")}.get(
            self.unit, (1.0, self.unit)
        )
        return f"{factor * error:.1f} {unit}".rstrip()


@dataclass(frozen=True)
class History:
    """Recorded episode, as the finders of causes read it.

    No finder reads the ``scene``, which is the truth of a simulation.

    Attributes:
        recorded: Recording of the episode.
    """

    recorded: Recorded

    @property
    def time(self) -> Floats:
        """Time of each tick, s, shape (T,)."""
        return self.recorded.arrays["time"]

    @cached_property
    def courses(self) -> tuple[ControllerCourse, ...]:
        """Course of each controller, in the order of the recording."""
        return tuple(_courses(self.recorded))

    @property
    def summary(self) -> Mapping[str, Any]:
        """Content of the recording's JSON file."""
        return self.recorded.summary

    @property
    def result(self) -> Mapping[str, Any]:
        """Recorded result of the episode."""
        result: Mapping[str, Any] = self.summary["result"]
        return result

    @property
    def limits(self) -> Mapping[str, Any]:
        """Limits of the main program; empty if unrecorded."""
        limits: Mapping[str, Any] = self.summary.get("limits", {}).get(self.result["program"], {})
        return limits

    @property
    def is_complete(self) -> bool:
        """True if the recording holds the facts of controllers and of sight."""
        return {"flags", "sight", "errors"} <= self.recorded.arrays.keys()

    @property
    def last(self) -> int:
        """Last tick."""
        return len(self.time) - 1

    @property
    def transitions(self) -> Sequence[Mapping[str, Any]]:
        """Transitions of all programs, by time."""
        transitions: Sequence[Mapping[str, Any]] = self.summary["transitions"]
        return transitions

    def lacks(self, course: ControllerCourse) -> Mask:
        """Return the ticks in which a controller is undefined, shape (T,)."""
        mask: Mask = (course.letters == "-") | self._ends(course, "-")
        return mask

    def rests(self, course: ControllerCourse) -> Mask:
        """Return the ticks in which a controller is at rest, shape (T,)."""
        mask: Mask = ((course.letters == "1") & course.defined) | self._ends(course, "1")
        return mask

    def _ends(self, course: ControllerCourse, letter: str) -> Mask:
        """Return the ticks of transitions with a predicate of a controller, shape (T,).

        A recorded tick has the letters after its transition, which may have ended its activity.
        """
        use, mask = course.program.rstrip("."), np.zeros(len(self.time), dtype=bool)
        for each in self.transitions:
            members = self.recorded.members(each)
            if course.member in members and each.get("use", "") == use:
                state = each["next_state"]
                mask[self.tick(each["time"])] |= state[members.index(course.member)] == letter
        return mask

    def tick(self, time: float) -> int:
        """Return the last tick up to a time, s."""
        return max(0, int(np.searchsorted(self.time, time + 1e-6, side="right")) - 1)

    def ticks(self, seconds: float) -> int:
        """Return the number of ticks in a duration, s; at least 1."""
        return max(1, self.tick(self.time[0] + seconds))

    @cached_property
    def defined(self) -> Mapping[str, Mask]:
        """Ticks in which each signal is defined, by its name, shape (T,)."""
        return {
            name: ~np.isnan(values.reshape(len(values), -1)).all(axis=1)
            for name, values in self.recorded.signals.items()
        }

    def channels(self, signal: str) -> Sequence[str]:
        """Return the visual channels of a signal; empty for another source."""
        channels: Sequence[str] = self.summary["signals"].get(signal, {}).get("channels", ())
        return channels

    def sight(self, channel: str) -> list[str]:
        """Return the name in ``SIGHT`` of a channel's object by tick; empty if unrecorded."""
        channels = list(self.summary.get("channels", ()))
        if channel not in channels or "sight" not in self.recorded.arrays:
            return []
        return [
            SIGHT[int(code)] for code in self.recorded.arrays["sight"][:, channels.index(channel)]
        ]

    def sees(self, signal: str, kinds: Sequence[str]) -> Mask:
        """Return the ticks in which a signal's sight is of some kinds of ``SIGHT``, shape (T,)."""
        seen: Mask = np.isin(np.array(self.sight(self.channels(signal)[0])), kinds)
        return seen if len(seen) else np.zeros(len(self.time), dtype=bool)

    @cached_property
    def places(self) -> Mapping[str, Floats]:
        """Positions of seen objects by the name of their signal, m, shape (T, 3)."""
        return {
            name: self.recorded.signals[name]
            for name, facts in self.summary["signals"].items()
            if facts["place"] and len(facts.get("channels", ())) == 1
        }

    @cached_property
    def hands(self) -> Sequence[str]:
        """Effectors that feel the forces that their controllers control."""
        return tuple(dict.fromkeys(each.hand for each in self.courses if each.grasps))

    @cached_property
    def approaches(self) -> Sequence[ControllerCourse]:
        """Courses that bring a position of the robot to a seen object."""
        return [
            each
            for each in self.courses
            if each.unit == "m" and each.base in self.places and not self.channels(each.feedback)
        ]

    @property
    def cell_forces(self) -> Floats:
        """Force of each load cell by tick, N, shape (T, cells, 3)."""
        loads = self.recorded.arrays["loads"]
        forces: Floats = loads.reshape(len(loads), len(self.summary["load_cells"]), 6)[..., :3]
        return forces

    def acting(self, tick: int, seconds: float) -> set[str]:
        """Return the unqualified names of the controllers that acted in a time, s, up to a tick."""
        span = slice(max(0, tick - self.ticks(seconds)), tick + 1)
        return {each.name.rpartition(".")[2] for each in self.courses if each.acts[span].any()}

    def closes(self, hand: str) -> Mask:
        """Return the ticks in which a controller of its forces moves a hand, (T,)."""
        acts = [e.acts for e in self.courses if e.grasps and (e.hand == hand or e.is_shared)]
        closes: Mask = np.any([np.zeros(len(self.time), dtype=bool), *acts], axis=0)
        return closes

    def holds(self, hand: str) -> Mask:
        """Return the ticks in which a hand is in contact since its forces came to rest, (T,)."""
        courses = [each for each in self.courses if each.hand == hand and each.grasps]
        rests = np.any([self.rests(each) for each in courses], axis=0)
        # At a change of action no controller of the hand is active for a tick or two.
        touches = np.any([each.defined for each in courses], axis=0) | rests
        touches = touches | (self.forces(hand) > CONTACT)
        holds = np.zeros(len(self.time), dtype=bool)
        for first, last in spans(touches):
            if rests[first : last + 1].any():
                holds[first + int(rests[first : last + 1].argmax()) : last + 1] = True
        return holds

    def cells_of(self, hand: str) -> list[int]:
        """Return the columns of the load cells of a hand, or of all hands for a group of them."""
        cells = self.summary["load_cells"]
        own = [n for n, cell in enumerate(cells) if cell.split(".")[0] == hand]
        return own or list(range(len(cells)))

    def forces(self, hand: str) -> Floats:
        """Return the largest force of a hand's load cells by tick, N, shape (T,)."""
        columns = self.cells_of(hand)
        if not columns:
            return np.zeros(len(self.time))
        largest: Floats = np.linalg.norm(self.cell_forces[:, columns], axis=2).max(axis=1)
        return largest

    def fingers(self, hand: str, tick: int) -> Floats:
        """Return the positions of the links with a hand's load cells, m, shape (cells, 3)."""
        known = [self._names.index(link) for link in self._tips(hand) if link in self._names]
        return np.array([self._track(place)[0][tick] for place in known]).reshape(-1, 3)

    def _tips(self, hand: str) -> Sequence[str]:
        """Return the links with a hand's load cells, or with all cells for a group of hands.

        Of a hand that only single fingers hold by, these fingers count.
        """
        cells: Mapping[str, str] = self.summary["robot"].get("cells", {})
        own = {cell: link for cell, link in cells.items() if cell.split(".")[0] == hand}
        grasps = [each for each in self.courses if each.grasps and each.hand == hand]
        used = {each.feedback.removesuffix(".force") for each in grasps}
        if used and used <= own.keys():
            own = {cell: own[cell] for cell in own if cell in used}
        return [*(own or cells).values()]

    def centres(self, hand: str) -> Floats:
        """Return the centre of the fingers by tick, m, (T, 3); NaN without fingers."""
        known = [self._names.index(link) for link in self._tips(hand) if link in self._names]
        tracks = [self._track(place)[0] for place in known] or [
            np.full((len(self.time), 3), np.nan)
        ]
        centres: Floats = np.mean(tracks, axis=0)
        return centres

    def spread(self, hand: str, tick: int) -> float:
        """Return the mean distance of the fingers from their centre, m; 0 for a single finger."""
        fingers = self.fingers(hand, tick)
        centre = fingers.mean(axis=0) if len(fingers) else np.zeros(3)
        return float(np.linalg.norm(fingers - centre, axis=1).mean()) if len(fingers) else 0.0

    def beside(self, hand: str, tick: int, position: Floats) -> float:
        """Return the horizontal distance of a position from the centre of the fingers, m."""
        return float(np.linalg.norm((position - self.fingers(hand, tick).mean(axis=0))[:2]))

    def known(self, signal: str) -> Floats:
        """Return the last known positions of a seen object, m, shape (T, 3), NaN before any."""
        values = self.places[signal]
        ticks = np.where(np.isnan(values[:, 0]), -1, np.arange(len(values)))
        latest = np.maximum.accumulate(ticks)
        known: Floats = np.where(latest[:, None] < 0, np.nan, values[np.maximum(latest, 0)])
        return known

    @cached_property
    def near(self) -> Mask:
        """True while any hand is at a seen object, which may touch it beside its cells, (T,)."""
        near = np.zeros(len(self.time), dtype=bool)
        cells = self.summary["robot"].get("cells", {})
        for link in set(cells.values()) & set(self._names):
            fingers = self._track(self._names.index(link))[0]
            for signal in self.places:
                distances = np.linalg.norm(fingers - self.known(signal), axis=1)
                near |= np.nan_to_num(distances, nan=np.inf) < _NEAR
        return near

    def arm_joints(self, hand: str) -> list[int]:
        """Return the columns of the joints that carry a hand, without its fingers."""
        names, chains = self._names, list[list[int]]()
        for cell, link in self.summary["robot"].get("cells", {}).items():
            place = names.index(link) if cell.split(".")[0] == hand and link in names else -1
            chain = list[int]()
            while place >= 0:
                chain += [self._links[place].column] if self._links[place].column >= 0 else []
                place = self._links[place].parent
            chains += [chain] if chain else []
        shared = set.intersection(*map(set, chains)) if chains else set()
        return sorted(shared - set(self.cell_joints.values()))

    def arm_of(self, hand: str) -> Sequence[str]:
        """Return the effectors whose tip a joint of a hand's arm moves."""
        names = {self.summary["joints"][column] for column in self.arm_joints(hand)}
        tips = self.summary["robot"].get("tips", {})
        return [name for name, tip in tips.items() if tip["joint"] in names]

    def pushes(self, hand: str) -> Mask:
        """Return the ticks in which the arm of a hand at an object is stopped, (T,).

        Its drives push, joints lag by most of the largest lead, and the hand stands still.
        """
        lead, joints = self.summary["robot"].get("lead"), self.arm_joints(hand)
        if not lead or not joints:
            return np.zeros(len(self.time), dtype=bool)
        window = self.ticks(_STOPPED)
        positions = self.recorded.arrays["positions"][:, joints]
        before = positions[np.maximum(np.arange(len(positions)) - window, 0)]
        still = np.abs(positions - before).max(axis=1) < _STILL * lead
        mask: Mask = (self.lags[:, joints] > _PUSHES * lead).any(axis=1) & still & self.near
        return mask

    @cached_property
    def cell_joints(self) -> Mapping[str, int]:
        """Column of the joint that moves the link of each load cell."""
        names, joints = self._names, dict[str, int]()
        for cell, link in self.summary["robot"].get("cells", {}).items():
            place = names.index(link) if link in names else -1
            while place >= 0 and self._links[place].column < 0:
                place = self._links[place].parent
            if place >= 0 and cell in self.summary["load_cells"]:
                joints[cell] = self._links[place].column
        return joints

    @cached_property
    def lags(self) -> Floats:
        """Distance of each joint from all its recent references, rad or m, shape (T, n).

        A joint that moves on is where its reference was a moment ago.
        """
        references, positions = (self.recorded.arrays[k] for k in ("references", "positions"))
        ticks = np.arange(len(positions))
        recent = [references[np.maximum(ticks - age, 0)] for age in range(AGES)]
        lags: Floats = np.min([np.abs(each - positions) for each in recent], axis=0)
        return lags

    @cached_property
    def touches(self) -> Mask:
        """True while a load cell of any hand feels a contact, which holds joints back."""
        forces = [np.zeros(len(self.time)), *map(self.forces, self.hands)]
        touches: Mask = np.max(forces, axis=0) > CONTACT
        return touches

    def pair(self, hand: str) -> tuple[str, str] | tuple[()]:
        """Return both arms of a group of two that hold objects between them; else nothing."""
        tips = tuple(self.summary["robot"].get("tips", {}))
        is_shared = any(each.is_shared and each.hand == hand for each in self.courses)
        return (tips[0], tips[1]) if is_shared and len(tips) == 2 else ()

    def palm_place(self, arm: str) -> Floats:
        """Return the positions of the link at the tip of an arm, m, (T, 3)."""
        link = self.summary["robot"]["tips"][arm]["link"]
        return self._track(self._names.index(link))[0]

    def lifted(self, hand: str) -> Floats:
        """Return the height of a hand, or the mean one of two arms, by tick, m, shape (T,)."""
        arms = self.pair(hand)
        if not arms:
            heights: Floats = self.centres(hand)[:, 2]
            return heights
        mean: Floats = np.mean([self.palm_place(arm)[:, 2] for arm in arms], axis=0)
        return mean

    def palm(self, hand: str) -> Floats:
        """Return the rotations of the tip that carries a hand, (T, 3, 3), whose z axis points.

        They are empty for a group of hands, and without a recorded tip.
        """
        tips = self.summary["robot"].get("tips", {})
        arms = self.arm_of(hand)
        return self.turns(tips[arms[0]]["link"]) if len(arms) == 1 else np.zeros((0, 3, 3))

    def turns(self, link: str) -> Floats:
        """Return the rotations of a link in the world frame, (T, 3, 3); none if it is unknown."""
        if link not in self._names:
            return np.zeros((0, 3, 3))
        return self._track(self._names.index(link))[1]

    def _track(self, place: int) -> tuple[Floats, Floats]:
        """Return positions, m, (T, 3), and rotations (T, 3, 3) of a link by its index, world frame.

        Hands have dozens of links on few chains: each link is computed once, for all ticks.
        """
        if place not in self._tracks:
            link, positions = self._links[place], self.recorded.arrays["positions"]
            values = positions[:, link.column] if link.column >= 0 else np.zeros(len(positions))
            at, turn = _motion(link, link.offset + link.ratio * values)
            if link.parent >= 0:
                base, above = self._track(link.parent)
                at, turn = base + np.einsum("tij,tj->ti", above, at), above @ turn
            self._tracks[place] = at, turn
        return self._tracks[place]

    @cached_property
    def _tracks(self) -> dict[int, tuple[Floats, Floats]]:
        return {}

    def span(self, effector: str, tick: int) -> tuple[Floats, float]:
        """Return the first joint of an effector, m, shape (3,), and a bound of its reach, m.

        The bound is infinite without a recorded tip, or if a joint slides.
        """
        tips = self.summary["robot"].get("tips", {})
        if effector not in tips:
            return np.zeros(3), np.inf
        tip = tips[effector]
        column = self.summary["joints"].index(tip["joint"])
        place = self._names.index(tip["link"])
        reach = float(np.linalg.norm(tip["offset"]))
        while place >= 0 and self._links[place].column != column:
            drawn = self._links[place]
            reach += np.inf if drawn.motion == "slide" else float(np.linalg.norm(drawn.position))
            place = drawn.parent
        return self._track(place)[0][tick], reach if place >= 0 else np.inf

    @cached_property
    def _links(self) -> Sequence[Any]:
        return read_links(self.summary["robot"], self.summary["joints"], with_shapes=False)

    @cached_property
    def _names(self) -> list[str]:
        return [each.name for each in self._links]

    def unit(self, joint: int) -> str:
        """Return the SI unit of a recorded joint's position by its column."""
        return "m" if any(e.column == joint and e.motion == "slide" for e in self._links) else "rad"

    def holder(self, index: int) -> str:
        """Return the name of a holder by its recorded index; empty for none."""
        return [*self.recorded.controllers, *HOLDERS, ""][index]


def spans(mask: Mask) -> Iterator[tuple[int, int]]:
    """Yield first and last tick of each run of ticks in which a mask (T,) is true."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], mask, [False]]).astype(np.int8)))
    for first, behind in zip(edges[::2], edges[1::2], strict=True):
        yield int(first), int(behind) - 1


def _courses(recorded: Recorded) -> Iterator[ControllerCourse]:
    summary, arrays = recorded.summary, recorded.arrays
    letters = np.array([list(each) for each in summary["predicates"]])
    shape = letters.shape
    errors = arrays.get("errors", np.full(shape, np.nan))
    bits = arrays.get("flags", np.zeros(shape)).astype(int)
    keys = ("feedback", "reference", "base", "effector", "unit", "requires", "potential")
    for column, name in enumerate(recorded.controllers):
        triple = summary["triples"][name]
        yield ControllerCourse(
            name=name,
            member=summary.get("leads", {}).get(name, ""),
            **{key: triple.get(key, "") for key in keys},
            letters=letters[:, column],
            errors=errors[:, column],
            acts=arrays["level_priority"][:, column] >= 0,
            flags=(bits[:, column, None] >> np.arange(len(FLAGS))) & 1 == 1,
            shares=arrays["level_share"][:, column],
            holders=arrays["level_held_by"][:, column],
            ranks=arrays["level_rank"][:, column],
            singular_values=arrays["level_singular_value"][:, column],
        )


def _motion(link: Any, values: Floats) -> tuple[Floats, Floats]:
    """Return positions, m, (T, 3), and rotations (T, 3, 3) of a link in its parent's frame.

    The motion of the joint by its values, rad or m, (T,), follows its constant origin.
    """
    axis = np.array(link.axis, dtype=float)
    axis /= np.linalg.norm(axis) or 1.0
    quaternion = np.array(link.quaternion, dtype=float)
    origin = np.array([turned(quaternion, unit) for unit in np.eye(3)]).T
    at = np.tile(np.array(link.position, dtype=float), (len(values), 1))
    if link.motion == "slide":
        at += values[:, None] * (origin @ axis)
    if link.motion != "turn":
        return at, np.broadcast_to(origin, (len(values), 3, 3))
    # Rodrigues' formula: R = I + sin(a) K + (1 - cos(a)) K K, where K v = axis x v.
    cross = np.cross(axis, np.eye(3)).T
    sines, rest = np.sin(values)[:, None, None], (1.0 - np.cos(values))[:, None, None]
    return at, origin @ (np.eye(3) + sines * cross + rest * (cross @ cross))
