"""Warnings about programs that can run but hardly as intended."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import NamedTuple

from cbdsl.checking.knowledge.impossible_states import check_possible, reads_what_is_known
from cbdsl.checking.program_context import ProgramContext, Steps
from cbdsl.checking.robot.pace import check_gain, check_window
from cbdsl.checking.rules.flow import active_members
from cbdsl.diagnostics.diagnostic import Place
from cbdsl.documents import program as written
from cbdsl.program.checked import Action, CheckedProgram
from cbdsl.program.controller import AlongNormals, Controller, Literal, Relative
from cbdsl.program.dry_run import StackLevel, levels
from cbdsl.types.potential import POTENTIALS
from cbdsl.types.resource import Resource
from cbdsl.types.source_record import is_visual, key_of
from cbdsl.types.state import ANY

# Rounding of half a turn and of a whole turn in rad.
_ROUNDING = 1e-3


def check_suspicious(
    context: ProgramContext,
    program: CheckedProgram,
    controllers: Sequence[Controller],
    actions: Mapping[str, Steps],
) -> None:
    """Warn of suspicious parts that can be found without running a program.

    Args:
        context: Context of the program's document.
        program: Checked program.
        controllers: Controllers of the program.
        actions: Paths of its actions in the document, by name.
    """
    for controller in controllers:
        document = context.document.controllers[controller.name]
        assert isinstance(document, written.ControllerSection), "compositions are no controllers"
        _ControllerCheck(context, document, controller).all()
    check_waiting(context, controllers)
    _hasty(context, controllers, program)
    _start(context, program)
    _background(context, program)
    _unchosen(context, program, actions)
    _used(context, program)
    for action in program.actions:
        if action.name in program.policy.values():
            _levels(context, program, action, actions[action.name])
    # With a wrong priority, a controller may lead wrongly and thus seem to be always defined.
    if not (context.document.steps or context.diagnostics.holds(("CB709",))):
        check_possible(program.policy, program, context.source, context.diagnostics)


class _ControllerCheck:
    def __init__(
        self, context: ProgramContext, document: written.ControllerSection, controller: Controller
    ) -> None:
        self._context = context
        self._steps = ("controllers", controller.name)
        self._document = document
        self._controller = controller

    def all(self) -> None:
        self._against_itself()
        self._zero_share()
        self._pace()
        self._whole_turns()

    def _whole_turns(self) -> None:
        """Warn of references that a joint without limits reaches by a shorter way."""
        controller, body = self._controller, self._context.body
        circular = body.circular(controller.feedback)
        is_relative = isinstance(controller.reference, Relative)
        match controller.reference:
            case Relative(offset=angles) | Literal(values=angles):
                pass
            case _:
                return
        # Both 350 deg and -10 deg are common spellings of one absolute angle. A displacement beyond
        # half a turn is reached by a shorter way, such as -90 deg for 270 deg.
        most = math.pi if is_relative else 2.0 * math.pi
        joints = body.effector_joints(controller.feedback)
        for i, (joint, angle) in enumerate(zip(joints, angles, strict=False)):
            if circular[i : i + 1] != (True,) or abs(angle) <= most + _ROUNDING:
                continue
            place = self._context.source.place(*self._steps, "reference")
            short = math.remainder(angle, 2.0 * math.pi)
            details = {"joint": joint, "written": f"{math.degrees(angle):.6g}"}
            self._context.add("CB723", place, short=f"{math.degrees(short):.3g}", **details)

    def _against_itself(self) -> None:
        controller, source = self._controller, self._context.source
        reference = controller.reference
        if isinstance(reference, Resource) and _are_same(reference, controller.feedback):
            place = source.place(*self._steps, "reference")
            self._context.add("CB708", place, name=reference.name)

    def _zero_share(self) -> None:
        """Warn of quiescence at a share of a reference of norm 0, which no residual can reach."""
        controller, source = self._controller, self._context.source
        if not controller.rewarded or controller.quiescence.within is None:
            return
        if _is_zero(controller):
            own = (*self._steps, "quiescence", "within")
            steps = own if source.holds(*own) else (*self._steps, "reference")
            self._context.add("CB711", source.place(*steps), name=controller.name)

    def _pace(self) -> None:
        context, controller = self._context, self._controller
        robot, source = context.body.document, context.source
        if self._document.gain is not None and POTENTIALS[controller.potential].residual:
            check_gain(controller.gain, robot, source, self._steps, context.diagnostics)
        window = controller.quiescence.window
        if self._document.quiescence is not None:
            seen = is_visual(controller.feedback.source)
            seen = seen and bool(robot.cameras)
            check_window(window, seen, robot, source, self._steps, context.diagnostics)


def _are_same(one: Resource, other: Resource) -> bool:
    """Return whether two names mean the same signal; equal fields of different sources do not."""
    return key_of(one.source) == key_of(other.source)


def _is_zero(controller: Controller) -> bool:
    match controller.reference:
        case Literal(values=values):
            return not any(values)
        case AlongNormals(force=force):
            return force == 0
        case Relative(offset=offset):
            return not any(offset)
    return False


def _hasty(
    context: ProgramContext, controllers: Sequence[Controller], program: CheckedProgram
) -> None:
    """Warn of controllers whose window of quiescence is at least as long as an action lasts."""
    source, longest, limit = context.source, program.transition_time, ("limits", "transition_time")
    slow = [(c.quiescence.window, c.name) for c in controllers]
    slow = sorted((each for each in slow if each[0] >= longest), reverse=True)
    # If the limit is in the document, the limit is too short: report it once.
    # Sorted by window, longest first: a limit above the first window suits all others.
    for window, name in slow[:1] if source.holds(*limit) else slow:
        own = ("controllers", name, "quiescence", "window")
        place = source.place(*(limit if source.holds(*limit) else own))
        details = {"longest": f"{longest:g}", "window": f"{window:g}"}
        context.add("CB714", place, name=name, **details)


def _start(context: ProgramContext, program: CheckedProgram) -> None:
    """Warn if no pattern of the policy matches the start, where no predicate is active."""
    patterns = [pattern for pattern in program.policy if not pattern.strip("X" + ANY)]
    # A missing policy may be learned; an empty one has no start.
    if context.source.holds("policy") and not patterns:
        state = "X" * len(program.members)
        context.add("CB706", context.source.key("policy"), state=state)


def _background(context: ProgramContext, program: CheckedProgram) -> None:
    name = str(program.background)
    if program.background is not None and name in (action.name for action in program.actions):
        context.add("CB716", context.source.place("background"), name=name)


def _unchosen(
    context: ProgramContext, program: CheckedProgram, actions: Mapping[str, Steps]
) -> None:
    """Note actions with members that a written policy never activates.

    Actions of one member may also be listed to begin the state in their order.
    """
    chosen = {*program.policy.values(), str(program.background)}
    active = {m for each in program.actions if each.name in chosen for m in active_members(each)}
    diagnostics = context.diagnostics
    # An end that only these actions show is the same mistake.
    is_written = context.document.policy and not (
        diagnostics.failed or diagnostics.holds(("CB722",))
    )
    for action in program.actions if is_written else ():
        if not active.issuperset(active_members(action)):
            context.add("CB732", context.source.place(*actions[action.name]), name=action.name)


def _used(context: ProgramContext, program: CheckedProgram) -> None:
    for action in program.actions:
        if action.program is not None and not action.program.policy:
            place = context.source.place("use", action.name, "program")
            context.add("CB705", place, name=action.program.name)


def _levels(context: ProgramContext, program: CheckedProgram, action: Action, steps: Steps) -> None:
    """Warn of controllers whose joints a controller above them always takes completely."""
    # Lower levels act in the null space of those above. A level that fixes as many directions as it
    # has joints leaves no null space to these joints. A level below that moves no other joints is
    # then without effect. The background is exempt, because it fills the remaining freedom of any
    # action.
    own = [level for level in levels(program, action) if not level.background]
    idle: dict[str, list[str]] = {}
    for i, level in enumerate(own):
        joints = frozenset(level.controller.joints)
        above = next((other for other in own[:i] if _takes_all(other, joints)), None)
        if above is not None:
            idle.setdefault(above.controller.name, []).append(level.controller.name)
    for name, below in idle.items():
        names = " and ".join(f"'{each}'" for each in below)
        context.add("CB709", context.source.place(*steps), above=name, names_below=names)


def _takes_all(above: StackLevel, joints: frozenset[str]) -> bool:
    """Return whether a level always fixes all of some joints, because it is never undefined."""
    controller = above.controller
    return (
        above.rows == len(controller.joints)
        and joints.issubset(controller.joints)
        and controller.feedback.type.name == "configuration"
        and POTENTIALS[controller.potential].residual
        and reads_what_is_known(controller)
    )


class _Wait(NamedTuple):
    """Wait of a controller for another, by a key of the document."""

    waiting: str
    awaited: str
    steps: Steps


Waits = Mapping[str, list[_Wait]]


def check_waiting(context: ProgramContext, controllers: Sequence[Controller]) -> None:
    """Report circles among the controllers that ``requires`` and ``seek: {once: ...}`` name.

    Args:
        context: Context of the program's document.
        controllers: Controllers of the program.
    """
    waits: dict[str, list[_Wait]] = {}
    for controller in controllers:
        for steps, awaited in _named(controller):
            waits.setdefault(controller.name, []).append(_Wait(controller.name, awaited, steps))
    # Circles of ``requires`` alone are reported first. The graph of all waits contains them again,
    # so that controllers that were reported are skipped.
    requires = {name: [w for w in own if w.steps[-1] == "requires"] for name, own in waits.items()}
    reported: set[str] = set()
    for code, verb, graph in (("CB585", "requires", requires), ("CB710", "waits for", waits)):
        for circle in _circles(graph):
            names = {wait.waiting for wait in circle}
            if reported.isdisjoint(names):
                _report(context, code, verb, circle)
                reported |= names


def _named(controller: Controller) -> Iterator[tuple[Steps, str]]:
    if controller.requires is not None:
        yield ("controllers", controller.name, "requires"), controller.requires
    if controller.seek is not None and controller.seek.once is not None:
        yield ("controllers", controller.name, "seek", "once"), controller.seek.once


def _circles(waits: Waits) -> Iterator[list[_Wait]]:
    """Yield the shortest way from each controller back to itself, if there is one."""
    for name in waits:
        if way := _way_back(name, waits):
            yield way


def _way_back(name: str, waits: Waits) -> list[_Wait] | None:
    # The search is breadth-first: the first way to a controller is a shortest one.
    ways: dict[str, list[_Wait]] = {name: []}
    ahead = [name]
    for each in ahead:  # the list grows
        for wait in waits.get(each, ()):
            way = [*ways[each], wait]
            if wait.awaited == name:
                return way
            if wait.awaited not in ways:
                ways[wait.awaited] = way
                ahead.append(wait.awaited)
    return None


def _report(context: ProgramContext, code: str, verb: str, circle: list[_Wait]) -> None:
    place: Callable[..., Place] = context.source.place
    first, *others = circle
    between = "".join(f"'{wait.waiting}', which {verb} " for wait in others)
    related = [(place(*w.steps), f"here '{w.waiting}' {verb} '{w.awaited}'") for w in others]
    details = {"name": first.waiting, "way": f"{between}{'it' if others else 'itself'}"}
    context.add(code, place(*first.steps), related=related, given="", **details)
