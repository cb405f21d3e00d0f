"""Dry run: properties of a checked program that need no execution."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import NamedTuple

from cbdsl.program.checked import Action, CheckedProgram
from cbdsl.program.controller import AlongNormals, Controller, Relative
from cbdsl.types.potential import POTENTIALS
from cbdsl.types.resource import Resource
from cbdsl.types.state import (
    ANY,
    PREDICATES,
    Predicate,
    closest_first,
    matches,
    overlap,
    split,
    tells_rest,
)


class StackLevel(NamedTuple):
    """One controller of a stack.

    Attributes:
        controller: Controller of the level.
        background: True if it comes from the program's background.
        rows: Maximum number of directions that it fixes, limited by its task and by its joints.
        free: Minimum number of its joints' degrees of freedom that the levels above leave to it. It
            is the bound of full ranks. All are left while the levels above are undefined, and more
            than the bound if their tasks are dependent, as at a singularity.
    """

    controller: Controller
    background: bool
    rows: int
    free: int


def levels(program: CheckedProgram, action: Action) -> tuple[StackLevel, ...]:
    """Return the stack of an action, highest priority first; empty for a program."""
    if action.composition is None:
        return ()
    # A controller of the action that is also in the background runs once, with its higher priority.
    own = tuple(reversed(action.controllers))
    below = () if program.background is None else tuple(reversed(program.background.controllers))
    stack = (*own, *(controller for controller in below if controller not in own))
    return tuple(
        StackLevel(
            controller, controller not in own, rows(controller), _free(stack[:place], controller)
        )
        for place, controller in enumerate(stack)
    )


def rows(controller: Controller) -> int:
    """Return the most directions that a controller fixes: at most its task rows or its joints."""
    # A scalar potential has one gradient, and therefore one row. A residual has a row per
    # coordinate.
    task, potential = 1, POTENTIALS[controller.potential]
    if potential.residual or potential.field:
        task = _task(controller)
    return min(task, len(controller.joints))


def _task(controller: Controller) -> int:
    """Return the number of task coordinates of a residual."""
    kind = controller.task
    if controller.axes is not None:
        return kind.factors * len(controller.axes)
    # A force along normals is one number a finger or hand.
    if isinstance(controller.reference, AlongNormals):
        return kind.factors
    return kind.size - (kind.factors if controller.free_axis else 0)


def _free(above: Iterable[Controller], controller: Controller) -> int:
    # A level with r rows over k of these joints takes at most min(r, k) directions from them. The
    # worst case is the sum over the levels, which independent tasks reach.
    joints = frozenset(controller.joints)
    taken = sum(min(rows(other), len(joints.intersection(other.joints))) for other in above)
    return max(0, len(joints) - taken)


def controllers(program: CheckedProgram) -> tuple[Controller, ...]:
    """Return all controllers of a program, each once, without those of the programs it uses."""
    own = [each for action in program.actions for each in action.controllers]
    below = () if program.background is None else program.background.controllers
    return tuple(dict.fromkeys((*own, *below)))


def resources(program: CheckedProgram) -> tuple[Resource, ...]:
    """Return all resources that a program's controllers are bound to, each once."""
    bindings: dict[str, Resource] = {}
    for controller in controllers(program):
        reference = controller.reference
        base = reference.base if isinstance(reference, Relative) else reference
        for bound in (controller.feedback, base, controller.effector):
            if isinstance(bound, Resource):
                bindings[bound.name] = bound
    return tuple(bindings.values())


def rewarding(action: Action) -> tuple[str, ...]:
    """Return the names of members that can earn the reward while an action runs (Eq 4.3)."""
    if action.program is not None:
        earns = any(rewarding(inner) for inner in action.program.actions)
        return (action.part,) if earns else ()
    assert action.composition is not None, "an action is a program or a composition"
    return tuple(p.name for p in action.composition.primitives if p.rewarded)


class Coverage(NamedTuple):
    """States that a policy decides, and states without an action.

    Attributes:
        states: Number of states, 4 per member, or 5 if rest is of two kinds.
        decided: Number of states that each pattern decides.
        undecided: Number of states without an action, in which the program ends.
    """

    states: int
    decided: Mapping[str, int]
    undecided: int


def coverage(program: CheckedProgram) -> Coverage:
    """Return the coverage of the states by the patterns of a program's policy."""
    # The number of states grows as 4^n with n members. Regions of states are therefore split
    # instead of enumerated, until one pattern decides a whole region or none touches it.
    decided = dict.fromkeys(program.policy, 0)
    everywhere, more = ANY * len(program.members), int(tells_rest(program.policy))
    undecided = _decide(everywhere, closest_first(program.policy), decided, more)
    return Coverage(_count(everywhere, more), decided, undecided)


def _count(region: str, more: int) -> int:
    """Return the number of states of a region if rest is of one kind, or of one more."""
    rests: int = (1 + more) ** region.count(Predicate.QUIESCENT)
    others: int = (len(PREDICATES) + more) ** region.count(ANY)
    return rests * others


def _decide(region: str, patterns: Sequence[str], decided: dict[str, int], more: int) -> int:
    """Add a region's states to the patterns that decide them; return the number left over."""
    touching = [pattern for pattern in patterns if overlap(region, pattern) is not None]
    states = _count(region, more)
    if not touching:
        return states
    if matches(touching[0], region):
        decided[touching[0]] += states
        return 0
    return sum(_decide(part, touching, decided, more) for part in split(region, touching[0]))
