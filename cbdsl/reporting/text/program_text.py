"""Checked programs as text for a terminal of 80 columns."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from textwrap import wrap
from typing import Any

from cbdsl.diagnostics.counting import count
from cbdsl.program.checked import Action, CheckedProgram
from cbdsl.program.controller import AlongNormals, Controller, Literal, Reference, Relative
from cbdsl.program.dry_run import controllers, coverage, levels, resources, rewarding
from cbdsl.program.uses import used_programs
from cbdsl.reporting.automaton_text import automaton_data
from cbdsl.types.casts import Chain
from cbdsl.types.potential import POTENTIALS
from cbdsl.types.resource import Resource
from cbdsl.types.resource_type import configuration

_WIDTH = 80
# Widest column of names; 37 columns are left for numbers.
_COLUMN = 43


def program_text(program: CheckedProgram) -> str:
    """Return a program as text, followed by each program that it uses."""
    parts = ("\n".join(_program(inner)) for inner in used_programs(program))
    return "\n\n".join(parts) + "\n"


def claims(program: CheckedProgram) -> dict[str, str]:
    """Return the conditions under which a program succeeds and fails, each as a phrase."""
    by_exits = "by exits of its steps" if program.steps else ""
    if program.success:
        success = by_exits or f"in state {' or '.join(program.success)}"
    elif earning := [name for name, each in program.primitives.items() if each.rewarded]:
        success = f"when {' or '.join(earning)} is rewarded"
    else:
        success = "when its last action comes to rest"
    failure = "by no state"
    if program.failure:
        failure = by_exits or f"in state {' or '.join(program.failure)}"
    if program.lost_time is not None:
        failure += f", or when an object is lost for {program.lost_time:g} s"
    return {"success": success, "failure": failure}


def reference_text(reference: Reference | None, unit: str) -> str:
    """Return the reference of a controller as text.

    Args:
        reference: Reference, or ``None``.
        unit: Unit of the feedback and the reference.
    """
    if reference is None:
        return "none"
    if isinstance(reference, Literal):
        return f"[{', '.join(f'{value:g}' for value in reference.values)}] {unit}"
    if isinstance(reference, AlongNormals):
        return f"{reference.force:g} N along normals"
    if isinstance(reference, Relative):
        return f"{reference} {unit}"
    return reference.name


def casts_text(controller: Controller) -> str:
    """Return the chains of casts of a controller, with the types between the casts."""
    first, last = str(controller.feedback.type), str(configuration(len(controller.joints)))
    return ", and ".join(_chain_text(chain, first, last) for chain in controller.chains)


def _chain_text(chain: Chain, first: str, last: str) -> str:
    between = [cast.target for cast in chain[:-1]] + [last] * bool(chain)
    steps = [word for pair in zip(chain, between, strict=True) for word in pair]
    return " → ".join(map(str, (first, *steps)))


def _program(program: CheckedProgram) -> Iterator[str]:
    parameters = ", ".join(f"{name} = {value}" for name, value in program.parameters.items())
    limit = f"{program.transition_time:g} s without a change of state"
    if program.idle_time is not None:
        limit += f", {program.idle_time:g} s with nothing on its way"
    yield f"{program.name} on {program.robot}, stage {program.stage or 'none'}"
    yield from _item("parameters", parameters or "none")
    yield from _item("state", ", ".join(program.members))
    for condition in program.conditions.values():
        yield from _item("condition", f"{condition.name}: {condition.text}")
    yield from _item("background", str(program.background or "none"))
    yield from _item("limits", f"{count(program.transitions, 'transition')}, {limit}")
    for key, text in claims(program).items():
        yield from _item(key, text)
    yield from _item("resources", ", ".join(resource.name for resource in resources(program)))
    yield "\nControllers"
    for controller in controllers(program):
        yield from _controller(controller)
    yield "\nActions, highest priority first"
    yield from _note(
        "'rows' is how many directions a controller fixes at most; 'free' is how many the "
        "controllers above leave to its joints at least. More are free while those above are "
        "undefined, or at singularities."
    )
    for action in program.actions:
        yield from _action(program, action)
    yield from _policy(program)


def _controller(controller: Controller) -> Iterator[str]:
    potential = POTENTIALS[controller.potential]
    kind = f"{potential.name} {potential.symbol} ({potential.equation})"
    yield f"  {controller.name}{', can be rewarded' if controller.rewarded else ''}"
    moves = (f"gain {controller.gain:g} /s", *_bounds(controller))
    yield from _item("potential", ", ".join((kind, *moves)), 4)
    yield from _item("feedback", _resource(controller.feedback), 4)
    yield from _item("reference", _reference(controller), 4)
    effector, joints = controller.effector, count(len(controller.joints), "joint")
    yield from _item("effector", f"{_resource(effector)}, {joints}", 4)
    yield from _item("casts", casts_text(controller), 4)
    if controller.requires is not None:
        yield from _item("requires", controller.requires, 4)


def _bounds(controller: Controller) -> Iterator[str]:
    """Yield the bounds of a task's velocity and acceleration."""
    scalar = POTENTIALS[controller.potential].scalar
    unit = "" if scalar else _grouped(controller.task.unit)
    if controller.speed is not None:
        # Forces and phi itself move only as fast as the joints that move them.
        is_of_joints = scalar or controller.task.unit.startswith("N")
        moved = _grouped(controller.joint_unit) if is_of_joints else unit
        yield f"speed {controller.speed:g} {moved}/s at most"
    if controller.acceleration is not None:
        yield f"acceleration {controller.acceleration:g} {unit}/s² at most"


def _grouped(unit: str) -> str:
    """Return a unit as a factor: several units are in parentheses."""
    return f"({unit})" if "," in unit else unit


def _resource(resource: Resource) -> str:
    return f"{resource.name}: {resource.type} in {resource.type.unit}, {resource.origin.value}"


def _reference(controller: Controller) -> str:
    reference = controller.reference
    if isinstance(reference, Resource):
        return _resource(reference)
    return reference_text(reference, controller.compared.unit)


def _action(program: CheckedProgram, action: Action) -> Iterator[str]:
    earning = " or ".join(rewarding(action))
    yield from _note(action.name)
    if action.program is not None:
        yield f"    runs program {action.program.name}, below"
    stack = levels(program, action)
    # Calls of shared controllers can have many arguments: their numbers stand below them.
    members = [level.controller.name for level in stack]
    width = max((len(name) for name in members if len(name) <= _COLUMN), default=0)
    if stack:
        yield f"    {'':{width}}  joints  rows  free"
    for level, name in zip(stack, members, strict=True):
        numbers = f"{len(level.controller.joints):6}{level.rows:6}{level.free:6}"
        below = "  background" if level.background else ""
        if len(name) > _COLUMN:
            yield f"    {name}"
        yield f"    {name if len(name) <= _COLUMN else '':{width}}  {numbers}{below}"
    yield from _item("rewarded", f"when {earning} comes to rest" if earning else "never", 4)
    for primitive in action.composition.primitives if action.composition else ():
        if primitive.earners and primitive.conditions:
            names = " and ".join(each.name for each in (*primitive.earners, *primitive.conditions))
            yield from _item("", f"{primitive.name} is at rest when {names} are", 4)


def _policy(program: CheckedProgram) -> Iterator[str]:
    if not program.policy:
        yield "\nPolicy: none; it needs one to run"
        return
    if program.steps:
        yield from _steps(automaton_data(program) or {"steps": ()})
        return
    shares = coverage(program)
    yield ""
    yield from wrap(
        f"Policy, over the {count(shares.states, 'state')} of {', '.join(program.members)}", _WIDTH
    )
    yield from _note("X not active, - undefined, 0 on its way, 1 at rest, * any")
    width = max(5, *(len(pattern) for pattern in program.policy))
    # Compositions of many controllers are wrapped within their column.
    most = max(shares.undecided, *shares.decided.values())
    numbers = max(len("decides"), len(str(most)))
    room = _WIDTH - 2 - width - 2 - 2 - numbers
    actions = min(room, max(6, *(len(action) for action in program.policy.values())))
    rows = [(name, action, shares.decided[name]) for name, action in program.policy.items()]
    if shares.undecided:
        rows.append(("other", "(ends)", shares.undecided))
    yield f"  {'state':{width}}  {'action':{actions}}  {'decides':>{numbers}}"
    for pattern, action, decided in rows:
        *above, last = wrap(action, actions, break_long_words=False, break_on_hyphens=False)
        lines = [*above, f"{last:{actions}}  {decided:{numbers}}"]
        for place, line in enumerate(lines):
            yield f"  {'' if place else pattern:{width}}  {line}"


def _steps(data: Mapping[str, Any]) -> Iterator[str]:
    """Yield the steps of a program with their exits; the first one starts."""
    yield "\nSteps, each with its exits in order"
    for step in sorted(data["steps"], key=lambda step: step["step"] != data["start"]):
        yield from _note(f"{step['step']}: {step['action']}")
        for each in step["exits"]:
            line = f"{each['when']}: {each['to']}"
            yield from wrap(line, _WIDTH, initial_indent="    ", subsequent_indent="      ")


def _item(key: str, text: str, indent: int = 2) -> Iterator[str]:
    """Yield the lines of a key and its text, wrapped if necessary."""
    margin = indent + 12
    lines = wrap(text, _WIDTH - margin, break_long_words=False, break_on_hyphens=False)
    first, *rest = lines or [""]
    yield f"{' ' * indent}{key:12}{first}"
    yield from (" " * margin + line for line in rest)


def _note(text: str) -> Iterable[str]:
    return wrap(text, _WIDTH, initial_indent="  ", subsequent_indent="  ")
