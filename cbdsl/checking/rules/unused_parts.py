"""Warnings about declarations without effect, and about names with two meanings."""

from __future__ import annotations

from collections.abc import Collection

from cbdsl.checking.program_context import ProgramContext


def check_unused(context: ProgramContext, used: Collection[str]) -> None:
    """Warn of unused controllers, programs and parameters, and of hidden names.

    Args:
        context: Program context.
        used: Controllers, programs and conditions that the program refers to.
    """
    document, source = context.document, context.source
    for section in ("controllers", "use", "conditions"):
        for name in getattr(document, section):
            if name not in used and name not in context.loaded.taken:
                context.add("CB701", source.key(section, name), name=name)
    for name in document.parameters:
        if name not in context.scope.used:
            section = "roles" if name in document.roles else "parameters"
            context.add("CB702", source.key(section, name), name=name)
    for name in document.controllers:
        if name in document.use:
            related = [(source.key("use", name), "the program")]
            place = source.key("controllers", name)
            context.add("CB703", place, related=related, name=name, other="program")
