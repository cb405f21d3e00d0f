"""Side by side: one program with the actions of several allocations of it (Section 5.3.1.1)."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace

from cbdsl.program.checked import Action, CheckedProgram
from cbdsl.program.controller import Composition, Controller, Primitive
from cbdsl.program.schema import Schema


def side_by_side(variants: Mapping[str, CheckedProgram], schema: Schema) -> CheckedProgram:
    """A program in which each allocation of each controller is an action, with a predicate.

    Programs that are actions are there once, and compositions are left out. What an action has
    moved stays where it is, as otherwise no later one could build on it; so nothing is in the
    background, and a member is accompanied by what its own background moves and neither it nor a
    member before it does, as a reach by the shaping of its hand. What seeks once another has
    arrived seeks at once, since that other acts no longer.

    Args:
        variants: the same program by the name of its allocation, with other resources.
        schema: has the features of the context.
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
    """The primitives of one allocation, each with what accompanies it."""
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
