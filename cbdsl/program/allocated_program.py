"""Allocated programs: one program whose actions can be run with several resources."""

from __future__ import annotations

from collections.abc import Mapping

from cbdsl.program.checked import Action, CheckedProgram
from cbdsl.program.controller import Composition, Controller, Primitive
from cbdsl.program.schema import Schema


def allocate(variants: Mapping[str, CheckedProgram], schema: Schema) -> CheckedProgram:
    """Return the program whose actions can be run under each of several allocations.

    A state has the predicates of the abstract actions, independently of their allocation. Joints
    that no action moves return to the background posture of the active allocation.

    Args:
        variants: Same program with different resources, by name of the allocation.
        schema: Schema that chooses among the allocations.
    """
    # All variants have the same abstract actions in the same order. An action is allocated if any
    # variant resolves it differently from the first one; so is each action of a single variant.
    base = next(iter(variants.values()))
    replaced = {
        action.name
        for variant in variants.values()
        for action, own in zip(variant.actions, base.actions, strict=True)
        if len(variants) == 1
        or (action.composition, action.program) != (own.composition, own.program)
    }
    # Shared actions have the same name in each variant and are merged here. Allocated ones have
    # distinct names.
    actions = {
        allocated.name: allocated
        for name, variant in variants.items()
        for action in variant.actions
        for allocated in [_allocated(action, name if action.name in replaced else "", variant)]
    }
    backgrounds = [each.background for each in variants.values() if each.background is not None]
    return base._replace(
        actions=tuple(actions.values()), background=_joined(backgrounds), schema=schema
    )


def _allocated(action: Action, allocation: str, variant: CheckedProgram) -> Action:
    if not allocation:
        return action._replace(abstract=action.name)
    name = f"{action.name} with {allocation}"
    return action._replace(
        name=name, abstract=action.name, allocation=allocation, background=variant.background
    )


def _joined(backgrounds: list[Composition]) -> Composition | None:
    """Return one composition of several; the first has the highest priority."""
    if not backgrounds:
        return None
    # The last primitive of a composition has the highest priority, so the backgrounds are inserted
    # in reverse. The controllers are part of the key, because the same primitive moves other joints
    # under another allocation. A primitive of several backgrounds has its highest priority: a
    # dictionary would keep the place of the first insertion, which is the lowest one.
    joined: dict[tuple[str, tuple[Controller, ...]], Primitive] = {}
    for background in reversed(backgrounds):
        for primitive in background.primitives:
            key = primitive.name, primitive.controllers
            joined.pop(key, None)
            joined[key] = primitive
    return Composition(tuple(joined.values()))
