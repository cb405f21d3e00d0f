"""Automaton of a program: its steps, the letters of their members, and the exits between them.

A step is the set of states in which its members are active (Eq 4.1). While it runs, each member has
one of the letters - 0 1, or s for a controller at rest beyond its tolerance, and all others have X.
A policy over states is therefore a finite automaton over these letters, whether it was written as
steps or as patterns of states.
"""

from __future__ import annotations

import itertools
from collections import deque
from collections.abc import Collection, Iterator, Mapping, Sequence
from typing import NamedTuple

from cbdsl.types.state import (
    ANY,
    ARRIVED,
    LETTERS,
    STUCK,
    Predicate,
    closest_first,
    outside,
    overlap,
)

Box = tuple[str, ...]
"""Letters of each member, as a string for each; the box is their product."""


class To(NamedTuple):
    """Target of an exit: a step, or the end of the program.

    Attributes:
        step: Name of the next step; empty at an end.
        end: ``success``, ``failure`` or ``end``; empty for a step.
        reason: Reason of a failure, as a clause; may be empty.
    """

    step: str = ""
    end: str = ""
    reason: str = ""

    def __str__(self) -> str:
        words = {"success": "succeed", "failure": "fail", "end": "end"}
        return self.step or f"{words[self.end]} {self.reason}".rstrip()


END = To(end="end")


class Exit(NamedTuple):
    """Exit of a step.

    Attributes:
        boxes: Alternative letters of the members for which it holds.
        to: Target.
        path: Path of the exit below its step, or of its pattern of states.
    """

    boxes: tuple[Box, ...]
    to: To
    path: tuple[str | int, ...] = ()


class ProgramStep(NamedTuple):
    """Step of a program: its action, and the exits by the letters of its members.

    Attributes:
        name: Name.
        action: Action that runs.
        members: Members that are active.
        values: Letters that each member can have.
        exits: Exits in order; the first one that holds applies.
        rest: Target if no exit holds: the step itself, or the end.
    """

    name: str
    action: str
    members: tuple[str, ...]
    values: Box
    exits: tuple[Exit, ...]
    rest: To

    def decide(self, letters: Sequence[str]) -> To:
        """Return the target for one letter of each member."""
        for exit_ in self.exits:
            if any(_holds(box, letters) for box in exit_.boxes):
                return exit_.to
        return self.rest

    def witness(self, place: int) -> Box | None:
        """Return values for which an exit applies, as a box, or ``None`` if there are none.

        Args:
            place: Index of the exit; the number of exits for the values without one.
        """
        before = [box for exit_ in self.exits[:place] for box in exit_.boxes]
        own = (self.values,) if place == len(self.exits) else self.exits[place].boxes
        inside = (meet(box, self.values) for box in own)
        parts = (_first_outside(box, before) for box in inside if box is not None)
        return next((part for part in parts if part is not None), None)

    @property
    def targets(self) -> tuple[tuple[To, Box], ...]:
        """Targets that some values lead to, each with such values."""
        tos = (*(exit_.to for exit_ in self.exits), self.rest)
        pairs = ((to, self.witness(place)) for place, to in enumerate(tos))
        return tuple((to, box) for to, box in pairs if box is not None)


class Automaton(NamedTuple):
    """Steps of a program.

    Attributes:
        steps: Steps by name.
        start: Name of the first step.
        members: Members whose letters join into a state, in order.
    """

    steps: Mapping[str, ProgramStep]
    start: str
    members: tuple[str, ...]

    def tables(self) -> Tables:
        """Return the patterns of states that choose the same targets."""
        return _Compiler(self).tables()

    def targets(self) -> dict[str, tuple[To, ...]]:
        """Return the targets that some values lead to, by step."""
        return {name: tuple(to for to, _ in step.targets) for name, step in self.steps.items()}

    def paths(self, targets: Mapping[str, tuple[To, ...]]) -> dict[str, tuple[str, ...]]:
        """Return a shortest path of steps to each step that is reached, which ends there."""
        paths: dict[str, tuple[str, ...]] = {self.start: (self.start,)}
        waiting = deque([self.start])
        while waiting:
            name = waiting.popleft()
            for to in targets[name]:
                if to.step in self.steps and to.step not in paths:
                    paths[to.step] = (*paths[name], to.step)
                    waiting.append(to.step)
        return paths


class Tables(NamedTuple):
    """Policy over patterns of states (Eq 4.1).

    Attributes:
        policy: Action by pattern.
        success: Patterns of states in which the program succeeds.
        failure: Reasons by pattern of states in which it fails; empty without one.
    """

    policy: Mapping[str, str]
    success: tuple[str, ...]
    failure: Mapping[str, str]


def _holds(box: Box, letters: Sequence[str]) -> bool:
    return all(letter in some for letter, some in zip(letters, box, strict=True))


def meet(one: Box, other: Box) -> Box | None:
    """Return the intersection of two boxes, or ``None`` if it is empty."""
    both = tuple("".join(x for x in a if x in b) for a, b in zip(one, other, strict=True))
    return both if all(both) else None


def without(box: Box, other: Box) -> Iterator[Box]:
    """Yield disjoint boxes that cover a box outside of another one."""
    for i, (a, b) in enumerate(zip(box, other, strict=True)):
        outside = "".join(x for x in a if x not in b)
        if outside:
            yield (*box[:i], outside, *box[i + 1 :])
        box = (*box[:i], "".join(x for x in a if x in b), *box[i + 1 :])
        if not box[i]:
            return


def _first_outside(box: Box, others: Sequence[Box]) -> Box | None:
    """Return a part of a box outside of all others, or ``None`` if they cover it."""
    touching = [other for other in others if meet(box, other) is not None]
    if not touching:
        return box
    parts = (_first_outside(part, touching[1:]) for part in without(box, touching[0]))
    return next((part for part in parts if part is not None), None)


# A state is decided by the patterns of success, then by those of failure in order, then by the
# pattern of the policy with the fewest wildcards, and the first of several. A box of a later exit
# that this order would prefer in a shared state is split, so that it leaves the state to the
# earlier exit. An end without an outcome is a state without any pattern.
class _Compiler:
    def __init__(self, automaton: Automaton) -> None:
        self._steps = automaton.steps
        self._places = {member: i for i, member in enumerate(automaton.members)}
        start = Predicate.INACTIVE * len(self._places)
        self._policy = {start: self._steps[automaton.start].action}
        self._success: dict[str, None] = {}
        self._failure: dict[str, str] = {}

    def tables(self) -> Tables:
        for step in self._steps.values():
            self._add(step)
        return Tables(self._policy, tuple(self._success), self._failure)

    def _add(self, step: ProgramStep) -> None:
        rest = Exit((tuple(LETTERS for _ in step.members),), step.rest)
        before: list[tuple[str, To]] = []
        for exit_ in (*step.exits, rest):
            waiting = [
                pattern for box in exit_.boxes for pattern in self._patterns(step, box, exit_.to)
            ]
            while waiting:
                pattern = waiting.pop(0)
                earlier = next((p for p, to in before if _yields(p, to, pattern, exit_.to)), None)
                if earlier is not None:
                    waiting[:0] = _outside(pattern, earlier, exit_.to)
                    continue
                before.append((pattern, exit_.to))
                self._put(pattern, exit_.to)

    def _put(self, pattern: str, to: To) -> None:
        if to.step:
            self._policy.setdefault(pattern, self._steps[to.step].action)
        elif to.end == "success":
            self._success[pattern] = None
        elif to.end == "failure":
            self._failure.setdefault(pattern, to.reason)

    def _patterns(self, step: ProgramStep, box: Box, to: To) -> Iterator[str]:
        """Yield the patterns of a box, without the states of steps that have fewer members."""
        # The first state has no active members, and its own pattern for the policy.
        others = [set(other.members) for other in self._steps.values()]
        others += [set()] if to.end else []
        lacking = [set(step.members) - other for other in others if other < set(step.members)]
        letters = list(map(_letters_of_pattern, box, step.values))
        for names in lacking:
            # Wildcards for all of these members would also match their letter X.
            places = [step.members.index(name) for name in names]
            if all(letters[place] == ANY for place in places):
                # An explicit rest in a success asks for arrival.
                letters[min(places)] = "-0" + (ARRIVED + STUCK if to.end == "success" else "1")
        for own in itertools.product(*letters):
            pattern = [Predicate.INACTIVE.value] * len(self._places)
            for member, letter in zip(step.members, own, strict=True):
                pattern[self._places[member]] = letter
            yield "".join(pattern)


def _letters_of_pattern(some: str, possible: str) -> str:
    """Return the letters of patterns for some of the letters that a member can have."""
    if set(some) >= set(possible):
        return ANY
    moving = "".join(each for each in some if each not in "1s")
    rests = "".join(each for each in some if each in "1s")
    if STUCK in possible and len(rests) == 1:
        rests = ARRIVED if rests == "1" else STUCK
    return moving + rests[:1]


def _yields(earlier: str, earlier_to: To, later: str, to: To) -> bool:
    """Return whether a later pattern would wrongly be preferred to an earlier one."""
    if to in (earlier_to, END) or overlap(earlier, later) is None:
        return False
    ranks = {"success": 0, "failure": 1, "": 2, "end": 3}
    before, after = ranks[earlier_to.end], ranks[to.end]
    fewer = to.end == "" and later.count(ANY) < earlier.count(ANY)
    return after < before or (after == before and fewer)


def _outside(pattern: str, other: str, to: To) -> list[str]:
    """Return the parts of a target's pattern of active members outside of another pattern."""
    parts = []
    for place, (own, letter) in enumerate(zip(pattern, other, strict=True)):
        others = [each for each in outside(own, letter) if each != Predicate.INACTIVE]
        if to.end == "success" and own == ANY and Predicate.QUIESCENT in others:
            # An explicit rest in a success asks for arrival.
            others[-1:] = [ARRIVED, STUCK]
        if others:
            parts += [pattern[:place] + each + pattern[place + 1 :] for each in others]
            pattern = pattern[:place] + letter + pattern[place + 1 :]
    return parts


def of_tables(
    tables: Tables,
    members: Sequence[str],
    active: Mapping[str, Sequence[str]],
    values: Mapping[str, str],
) -> Automaton | None:
    """Return the automaton of a policy over patterns of states.

    Its steps are the actions that the policy chooses, by their names.

    Args:
        tables: Patterns of states.
        members: Members whose letters join into a state.
        active: Members that are active while an action runs, by its name.
        values: Letters that each member can have.

    Returns:
        Automaton; ``None`` if no action follows from the state without active members.
    """
    start = next((p for p in closest_first(tables.policy) if not p.strip("X" + ANY)), None)
    if start is None:
        return None
    # A success is a failure if a member that has to be at rest is beyond its tolerance.
    arrived = str.maketrans(Predicate.QUIESCENT, ARRIVED)
    rules = [(pattern.translate(arrived), To(end="success")) for pattern in tables.success]
    rules += [(pattern, To(end="failure", reason=why)) for pattern, why in tables.failure.items()]
    rules += [(pattern, To(end="failure")) for pattern in tables.success]
    rules += [(pattern, To(tables.policy[pattern])) for pattern in closest_first(tables.policy)]
    steps = {}
    for action in dict.fromkeys(tables.policy.values()):
        own = tuple(member for member in members if member in active[action])
        exits = [Exit((box,), to) for pattern, to in rules if (box := _box(pattern, members, own))]
        letters = tuple(values[member] for member in own)
        steps[action] = ProgramStep(action, action, own, letters, tuple(exits), END)
    return Automaton(steps, tables.policy[start], tuple(members))


# Letters of active members by those of patterns.
_LETTERS = {ANY: LETTERS, Predicate.QUIESCENT.value: "1s", ARRIVED: "1"}


def _box(pattern: str, members: Sequence[str], active: Collection[str]) -> Box | None:
    """Return the letters of active members in a pattern; ``None`` if it matches none of them."""
    letters = []
    for member, letter in zip(members, pattern, strict=True):
        if member in active:
            letters.append(_LETTERS.get(letter, letter))
        elif letter not in (ANY, Predicate.INACTIVE):
            return None
    return None if Predicate.INACTIVE in letters else tuple(letters)
