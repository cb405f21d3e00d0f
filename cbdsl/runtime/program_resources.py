"""Resources that a program reads."""

from __future__ import annotations

from collections.abc import Sequence

from cbdsl.program.checked import CheckedProgram
from cbdsl.types.resource import Resource


def resources_of(program: CheckedProgram) -> Sequence[Resource]:
    """Return every resource that a program and the programs it uses can read."""
    resources: dict[Resource, None] = {}
    compositions = [program.background, *(action.composition for action in program.actions)]
    for composition in compositions:
        for controller in composition.controllers if composition else ():
            resources.update(dict.fromkeys(controller.resources))
    for condition in program.conditions.values():
        resources.update(dict.fromkeys(condition.resources))
    for action in program.actions:
        if action.program is not None:
            resources.update(dict.fromkeys(resources_of(action.program)))
    if program.schema is not None:
        resources.update(dict.fromkeys(program.schema.features.values()))
    for look in program.looks.values():
        resources.update(dict.fromkeys(resources_of(look.program)))
    return list(resources)
