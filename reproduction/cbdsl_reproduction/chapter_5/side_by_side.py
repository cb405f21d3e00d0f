"""Side by side: one program with the actions of several allocations of it (Section 5.3.1.1)."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace

from cbdsl.api.program import Action, CheckedProgram, Composition, Controller, Primitive, Schema


def side_by_side(variants: Mapping[str, CheckedProgram], schema: Schema) -> CheckedProgram:
    """Return a program in which each allocation of each controller is an action with a predicate.

    Programs that are actions occur once, and compositions are left out. Moved joints stay in place
    between actions, because later actions build on them, so the program has no background. A
    member is accompanied by controllers of its own background. They move joints that neither it
    nor a member before it moves, for example the shaping of the hand during a reach. A controller
    that seeks after another has arrived seeks immediately, because the other no longer acts.

    Args:
        variants: Same program with different resources, by name of the allocation.
        schema: Schema with the features of the context.
    """
    base = next(iter(variants.values()))
    programs = [action for action in base.actions if action.program is not None]
    primitives = {
        primitive.name: primitive
        for name, variant in variants.items()
        for primitive in _members(name, variant)
    }
    allocated = [
        Action(member, Composition((primitive,)), allocation=member.partition("(")[2].rstrip(")"))
        for member, primitive in primitives.items()
    ]
    return base._replace(
        members=(*(action.name for action in programs), *primitives),
        primitives=primitives,
        actions=(*programs, *allocated),
        policy={},
        background=None,
        schema=schema,
    )


def _members(allocation: str, program: CheckedProgram) -> Iterator[Primitive]:
    """Yield the primitives of one allocation, each with its background controllers."""
    moved: set[str] = set()
    for name in program.members:
        primitive = program.primitives.get(name)
        if primitive is None:
            continue
        moved |= {joint for each in primitive.controllers for joint in each.joints}
        along = [each for each in _background(program) if not moved & set(each.joints)]
        controllers = (*along, *(_at_once(each) for each in primitive.controllers))
        yield Primitive(f"{name}({allocation})", controllers, primitive.earning)


def _background(program: CheckedProgram) -> Iterator[Controller]:
    if program.background is not None:
        yield from program.background.controllers


def _at_once(controller: Controller) -> Controller:
    if controller.seek is None or controller.seek.once is None:
        return controller
    return replace(controller, seek=controller.seek._replace(once=None))
