"""A checked program as text for a terminal of 80 columns."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from textwrap import wrap

from cbdsl.errors.counting import count
from cbdsl.program.checked import Action, CheckedProgram
from cbdsl.program.controller import AlongNormals, Controller, Literal, Reference
from cbdsl.program.dry_run import controllers, coverage, levels, resources, rewarding
from cbdsl.types.potential import POTENTIALS
from cbdsl.types.resource import Resource

_WIDTH = 80


def program_text(program: CheckedProgram) -> str:
    """A program and, after it, those that it uses, each once."""
    parts = ("\n".join(_program(inner)) for inner in _used(program, []))
    return "\n\n".join(parts) + "\n"


def reference_text(reference: Reference | None) -> str:
    """A reference as people read it, in SI."""
    if reference is None:
        return "none"
    if isinstance(reference, Literal):
        return f"[{', '.join(f'{value:g}' for value in reference.values)}]"
    if isinstance(reference, AlongNormals):
        return f"{reference.force:g} N along normals"
    return reference.name


def _used(program: CheckedProgram, seen: list[CheckedProgram]) -> list[CheckedProgram]:
    if program not in seen:
        seen.append(program)
        for action in program.actions:
            if action.program is not None:
                _used(action.program, seen)
    return seen


def _program(program: CheckedProgram) -> Iterator[str]:
    parameters = ", ".join(f"{name} = {value}" for name, value in program.parameters.items())
    limit = f"{program.transition_time:g} s without a change of state"
    yield f"{program.name} on {program.robot}, stage {program.stage or 'none'}"
    yield from _item("parameters", parameters or "none")
    yield from _item("state", ", ".join(program.members))
    yield from _item("background", str(program.background or "none"))
    yield from _item("limits", f"{count(program.transitions, 'transition')}, {limit}")
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
    bounds = {"speed": controller.speed, "acceleration": controller.acceleration}
    limits = [f"{key} {value:g} at most" for key, value in bounds.items() if value is not None]
    kind = f"{potential.name} {potential.symbol} ({potential.equation})"
    yield f"  {controller.name}{', can be rewarded' if controller.rewarded else ''}"
    yield from _item("potential", ", ".join((kind, f"gain {controller.gain:g} /s", *limits)), 4)
    yield from _item("feedback", _resource(controller.feedback), 4)
    yield from _item("reference", _reference(controller.reference), 4)
    effector, joints = controller.effector, count(len(controller.joints), "joint")
    yield from _item("effector", f"{_resource(effector)}, {joints}", 4)
    yield from _item("casts", " → ".join(controller.chain), 4)


def _resource(resource: Resource) -> str:
    return f"{resource.name}: {resource.type}, {resource.origin.value}"


def _reference(reference: Reference | None) -> str:
    return _resource(reference) if isinstance(reference, Resource) else reference_text(reference)


def _action(program: CheckedProgram, action: Action) -> Iterator[str]:
    earning = " or ".join(rewarding(action))
    yield f"  {action.name}"
    if action.program is not None:
        yield f"    runs program {action.program.name}, below"
    stack = levels(program, action)
    if stack:
        width = max(len(level.controller.name) for level in stack)
        yield f"    {'':{width}}  joints  rows  free"
    for level in stack:
        numbers = f"{len(level.controller.joints):6}{level.rows:6}{level.free:6}"
        below = "  background" if level.background else ""
        yield f"    {level.controller.name:{width}}  {numbers}{below}"
    yield from _item("rewarded", f"when {earning} comes to rest" if earning else "never", 4)


def _policy(program: CheckedProgram) -> Iterator[str]:
    if not program.policy:
        yield "\nPolicy: none; it needs one to run"
        return
    shares = coverage(program)
    yield f"\nPolicy, over the {count(shares.states, 'state')} of {', '.join(program.members)}"
    yield from _note("X not active, - undefined, 0 on its way, 1 at rest, * any")
    width = max(5, *(len(pattern) for pattern in program.policy))
    actions = max(6, *(len(action) for action in program.policy.values()))
    yield f"  {'state':{width}}  {'action':{actions}}  decides"
    for pattern, action in program.policy.items():
        yield f"  {pattern:{width}}  {action:{actions}}  {shares.decided[pattern]:7}"
    if shares.undecided:
        yield f"  {'other':{width}}  {'(ends)':{actions}}  {shares.undecided:7}"


def _item(key: str, text: str, indent: int = 2) -> Iterator[str]:
    """A key and its text, which may go on in the lines below."""
    margin = indent + 12
    lines = wrap(text, _WIDTH - margin, break_long_words=False, break_on_hyphens=False)
    first, *rest = lines or [""]
    yield f"{' ' * indent}{key:12}{first}"
    yield from (" " * margin + line for line in rest)


def _note(text: str) -> Iterable[str]:
    return wrap(text, _WIDTH, initial_indent="  ", subsequent_indent="  ")
