"""Flow of a program: faults of its automaton that are certain before anything moves."""

from __future__ import annotations

from collections.abc import Sequence

from cbdsl.checking.knowledge.impossible_states import is_always_defined
from cbdsl.checking.program_context import ProgramContext, Steps
from cbdsl.language.exit import OF_KIND
from cbdsl.program.automaton import END, Automaton, Exit, ProgramStep, Tables, meet, of_tables
from cbdsl.program.checked import Action, CheckedProgram
from cbdsl.program.controller import Controller, Relative
from cbdsl.program.dry_run import levels, rewarding, rows
from cbdsl.types.resource import Origin
from cbdsl.types.state import LETTERS, STUCK, Predicate, tells_rest

_OF_WORLD = (Origin.ENVIRONMENT, Origin.TRIANGULATION)

# The automaton over-approximates a run: any member may have any of its letters next. A step or an
# exit that it does not reach is therefore never reached, while a path that it has may be one that
# the physical world excludes.


def automaton_of(program: CheckedProgram) -> Automaton | None:
    """Return the automaton of a checked program, that of its steps as written if it has any.

    ``None`` if it has no policy or no start.
    """
    written = program.automaton
    ways = (*program.policy, *program.success, *program.failure)
    tells = written is not None or tells_rest(ways)
    values = {member: values_of(member, program, tells=tells) for member in program.members}
    if written is not None:
        steps = {
            name: step._replace(
                values=meet(step.values, tuple(values[member] for member in step.members))
                or step.values
            )
            for name, step in written.steps.items()
        }
        return written._replace(steps=steps)
    reasons = {pattern: program.reasons.get(pattern, "") for pattern in program.failure}
    tables = Tables(program.policy, program.success, reasons)
    active = {action.name: active_members(action) for action in program.actions}
    return of_tables(tables, program.members, active, values)


def active_members(action: Action) -> tuple[str, ...]:
    """Return the names of the members that are active while an action runs."""
    if action.composition is None:
        return (action.name, *action.conditions)
    names = tuple(primitive.name for primitive in action.composition.primitives)
    return names + action.conditions


def values_of(member: str, program: CheckedProgram, *, tells: bool) -> str:
    """Return the letters that a member can have while it is active.

    Args:
        member: Name of the member.
        program: Checked program.
        tells: True if a controller that is stuck has another letter than one that has arrived.
    """
    condition = program.conditions.get(member)
    if condition is not None:
        letters = OF_KIND["condition"]
        return letters.replace("-", "") if condition.is_always_defined else letters
    primitive = program.primitives.get(member)
    if primitive is None:
        return OF_KIND["program"]
    letters = OF_KIND["controller"]
    if is_always_defined(primitive.lead):
        letters = letters.replace(Predicate.UNDEFINED, "")
    return letters if tells else letters.replace(STUCK, "")


def check_flow(context: ProgramContext, program: CheckedProgram) -> None:
    """Report the faults of a program's automaton, each with the shortest path that leads there.

    Args:
        context: Context of the program's document.
        program: Checked program.
    """
    automaton = automaton_of(program)
    if automaton is not None:
        _FlowCheck(context, program, automaton).all()


class _FlowCheck:
    def __init__(
        self, context: ProgramContext, program: CheckedProgram, automaton: Automaton
    ) -> None:
        self._context, self._program, self._automaton = context, program, automaton
        self._targets = automaton.targets()
        self._paths = automaton.paths(self._targets)
        self._has_steps = bool(context.document.steps)

    def all(self) -> None:
        """Report all faults."""
        traps = self._traps()
        for step in self._automaton.steps.values():
            if step.name not in self._paths:
                # An idle pattern, or an unreached end, is the same mistake.
                if not self._context.diagnostics.holds(("CB707", "CB722")):
                    self._add("CB724", step, self._path(step), step=step.name)
                continue
            if self._has_steps:
                for place, exit_ in enumerate(step.exits):
                    # The failure of stuck members belongs to the exit before it.
                    if place == 0 or exit_.path != step.exits[place - 1].path:
                        self._check_exit(step, place, exit_)
                if step.name not in traps:
                    self._check_rest(step)
            else:
                self._check_going_on(step)
            self._check_holding(step)
            self._check_support(step)
        for name in traps:
            step = self._automaton.steps[name]
            # One finding for the step by which the steps without a way out are entered.
            if not any(before in traps for before in self._paths[name][:-1]):
                self._add("CB726", step, self._path(step), step=name)
        self._check_cycles()

    def _add(self, code: str, at: ProgramStep, path: Steps, **details: object) -> None:
        source = self._context.source
        place = source.key(*path) if self._has_steps else source.place(*path)
        way = " -> ".join(self._paths.get(at.name, ()))
        self._context.add(code, place, way=f" (path: {way})" if way else "", **details)

    def _path(self, step: ProgramStep, exit_: Exit | None = None) -> Steps:
        """Return the path of a step or an exit in the document."""
        if self._has_steps:
            return ("steps", step.name, *(exit_.path if exit_ else ()))
        policy = self._program.policy.items()
        return ("policy", next(pattern for pattern, name in policy if name == step.action))

    def _check_exit(self, step: ProgramStep, place: int, exit_: Exit) -> None:
        if step.witness(place) is not None:
            return
        if any(meet(box, step.values) is not None for box in exit_.boxes):
            reason = "earlier exits of the step hold in all its cases"
        else:
            reason = "no values of its members meet it"
            never = _never_undefined(exit_, step)
            reason = f"'{never}' is always defined" if never else reason
        name = str(exit_.path[-1])
        self._add("CB725", step, self._path(step, exit_), exit=name, reason=reason)

    def _traps(self) -> list[str]:
        """Return the reached steps from which no path leads to an end or a reward."""
        tos = {to for targets in self._targets.values() for to in targets}
        # A program without any end, such as one that follows an object, goes on by design.
        if self._program.episode_time is not None or not any(to.end for to in tos):
            return []
        leaving = {
            name
            for name in self._paths
            if self._is_rewarded(name) or any(to.end for to in self._targets[name])
        }
        before = -1
        while len(leaving) != before:
            before = len(leaving)
            for name in self._paths:
                if any(to.step in leaving for to in self._targets[name]):
                    leaving.add(name)
        return [name for name in self._paths if name not in leaving]

    def _is_rewarded(self, name: str) -> bool:
        """Return whether a reward may end the program in a step."""
        program, action = self._program, self._automaton.steps[name].action
        earning = (each for each in program.actions if each.name == action)
        return program.reward_ends and any(rewarding(each) for each in earning)

    def _check_cycles(self) -> None:
        """Report steps that follow each other although no controller of them acts."""
        # An undefined controller moves nothing, so that each tick finds the same letters again.
        idle: dict[str, str] = {}
        programs = {action.name for action in self._program.actions if action.program is not None}
        for name in self._paths:
            step = self._automaton.steps[name]
            undefined = tuple(
                LETTERS if member in self._program.conditions else Predicate.UNDEFINED.value
                for member in step.members
            )
            box = meet(undefined, step.values)
            if box is None or not programs.isdisjoint(step.members):
                continue
            # Only one target for all values of its conditions is certain.
            tos = {to.step for to, _ in step._replace(values=box).targets}
            idle[name] = tos.pop() if len(tos) == 1 else name
        for name in list(idle):
            cycle = [name]
            while idle.get(cycle[-1], "") and idle[cycle[-1]] not in cycle:
                cycle.append(idle[cycle[-1]])
            if len(cycle) > 1 and idle.get(cycle[-1]) == name and name == min(cycle):
                step = self._automaton.steps[name]
                steps = " -> ".join((*cycle, name))
                self._add("CB727", step, self._path(step), steps=steps)

    def _check_rest(self, step: ProgramStep) -> None:
        """Report a step that goes on although all of its members are at rest."""
        conditions = self._program.conditions
        resting = tuple(LETTERS if name in conditions else "1s" for name in step.members)
        box = meet(resting, step.values)
        if box is None or self._is_rewarded(step.name):
            return
        if {to.step for to, _ in step._replace(values=box).targets} == {step.name}:
            self._add("CB734", step, self._path(step), step=step.name)

    def _check_going_on(self, step: ProgramStep) -> None:
        """Report an action that ends the program as soon as its controllers move."""
        conditions = self._program.conditions
        moving = tuple(LETTERS if name in conditions else "0" for name in step.members)
        box = meet(moving, step.values)
        if box is not None and {to for to, _ in step._replace(values=box).targets} == {END}:
            state = "".join(
                "0" if name in step.members and name not in conditions else "X"
                for name in self._automaton.members
            )
            self._add("CB731", step, self._path(step), action=step.action, state=state)

    def _stack(self, step: ProgramStep) -> list[Controller]:
        """Return the controllers of a step, highest priority first."""
        action = next(each for each in self._program.actions if each.name == step.action)
        return [level.controller for level in levels(self._program, action)]

    # An object is held while a controller that requires a grip is defined. It may be let go once a
    # member of an exit has measured a contact or a place. An exit by joints and displacements alone
    # leads to a hand that opens in the air.
    def _check_support(self, step: ProgramStep) -> None:
        """Report an exit from a step that carries an object to one that opens the hand."""
        stack, primitives = self._stack(step), self._program.primitives
        grips = [each for each in stack if each.name in {other.requires for other in stack}]
        for place, exit_ in enumerate(step.exits):
            after = self._automaton.steps.get(exit_.to.step)
            if after is None or step.witness(place) is None or after.name == step.name:
                continue
            for box in exit_.boxes:
                parts = zip(step.members, box, step.values, strict=True)
                named = {name: own for name, own, every in parts if not set(every) <= set(own)}
                carries = {
                    each: own
                    for each, own in zip(step.members, box, strict=True)
                    if each in primitives and any(c.requires for c in primitives[each].controllers)
                }
                if any(own == Predicate.UNDEFINED for own in carries.values()) or not carries:
                    continue
                if not any(self._tells_place(name) for name in named):
                    grip = next((g for g in grips if _opens(self._stack(after), g)), None)
                    if grip is not None:
                        details = {"step": after.name, "grip": grip.name, "before": step.name}
                        self._add("CB733", step, self._path(step, exit_), **details)
                        return

    def _tells_place(self, member: str) -> bool:
        """Return whether a member compares a signal of the world, or a hand with a place in it."""
        program = self._program
        if member in program.conditions:
            return any(each.origin in _OF_WORLD for each in program.conditions[member].resources)
        if member not in program.primitives:
            return True  # a program has its own ends
        lead = program.primitives[member].lead
        is_here = isinstance(lead.reference, Relative) and lead.reference.base is None
        return lead.feedback.origin in _OF_WORLD or (
            lead.feedback.origin is Origin.KINEMATICS and not is_here
        )

    def _check_holding(self, step: ProgramStep) -> None:
        """Report controllers whose required controller has no joint left to act with."""
        stack = self._stack(step)
        named = {controller.name: controller for controller in stack}
        for controller in stack:
            required = named.get(controller.requires or "")
            if required is None:
                continue
            above = stack[: stack.index(required)]
            taker = next((other for other in above if _takes(other, required)), None)
            if taker is not None:
                details = {"name": controller.name, "required": required.name, "taker": taker.name}
                self._add("CB728", step, self._path(step), step=step.name, **details)
                return


def _opens(stack: Sequence[Controller], grip: Controller) -> bool:
    """Return whether the joints of a grip go to a posture, and nothing holds with them."""
    acting = [each for each in stack if not set(each.joints).isdisjoint(grip.joints)]
    postures = [each for each in acting if each.feedback.origin is Origin.PROPRIOCEPTION]
    return bool(postures) and postures == acting


def _takes(above: Controller, below: Controller) -> bool:
    """Return whether a controller fixes all joints of another one, which it is not about."""
    joints = set(above.joints)
    return rows(above) == len(joints) and joints.issuperset(below.joints)


def _never_undefined(exit_: Exit, step: ProgramStep) -> str:
    """Return a member of an exit that has to be undefined and never is; empty if there is none."""
    for box in exit_.boxes:
        for member, letters, values in zip(step.members, box, step.values, strict=True):
            if letters == Predicate.UNDEFINED and letters not in values:
                return member
    return ""
