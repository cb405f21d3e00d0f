"""Kinds of resources that parameters of a program may stand for."""

from __future__ import annotations

from cbdsl.checking.program_context import ProgramContext, Steps
from cbdsl.documents.program import ProgramDocument
from cbdsl.program.steps import written_steps
from cbdsl.types.allotment import ALLOTMENTS, PROGRAM, WHOLE, allotment


def exchangeable(document: ProgramDocument) -> set[str]:
    """Return the names that other programs may stand in for: the program itself and its members."""
    members = {*document.use, *document.controllers}
    in_steps = (m for step in written_steps(document, lambda *_: None) for m in step.members)
    return {WHOLE, *members.intersection((*map(str.strip, document.actions), *in_steps))}


def check_allotments(context: ProgramContext) -> None:
    """Check that each exchangeable name exists, occurs once, and has a known kind."""
    document, source = context.document, context.source
    parameters = source.declared(document.parameters, "parameters")
    first: dict[str, Steps] = {}
    for group, wanted in document.resources.items():
        for name, text in wanted.items():
            steps: Steps = ("resources", group, name)
            kind = allotment(text)
            # An unreadable kind may be that of a program.
            is_program = kind is not None and kind.kind == PROGRAM
            programs = exchangeable(document) if kind is None or is_program else set()
            if name not in programs and (is_program or name not in parameters):
                names = sorted(programs if is_program else parameters)
                context.add("CB402", source.key(*steps), names=names, name=name, hint="")
            elif name in first:
                related = [(source.key(*first[name]), "it is replaced here")]
                context.add("CB411", source.key(*steps), related=related, name=name)
            else:
                first[name] = steps
            if kind is None:
                context.add("CB412", source.place(*steps), names=list(ALLOTMENTS), name=text)
