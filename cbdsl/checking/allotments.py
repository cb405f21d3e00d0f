"""The kinds of resources that parameters of a program may stand for."""

from __future__ import annotations

from cbdsl.checking.context import ProgramContext, Steps
from cbdsl.types.allotment import ALLOTMENTS, PROGRAM, WHOLE, allotment


def check_allotments(context: ProgramContext) -> None:
    """Check that a program lets parameters of its own be replaced, each once, by a known kind."""
    document, source = context.document, context.source
    parameters = source.declared(document.parameters, "parameters")
    first: dict[str, Steps] = {}
    for group, wanted in document.resources.items():
        for name, text in wanted.items():
            steps: Steps = ("resources", group, name)
            kind = allotment(text)
            whole = {WHOLE} if kind is not None and kind.kind == PROGRAM else set()
            # A kind that cannot be read may be that of a program.
            may_be_whole = kind is None and name == WHOLE
            if name not in (whole or parameters) and not may_be_whole:
                context.add(
                    "CB402",
                    source.key(*steps),
                    names=sorted(whole or parameters),
                    name=name,
                    hint="",
                )
            elif name in first:
                related = [(source.key(*first[name]), "it is replaced here")]
                context.add("CB411", source.key(*steps), related=related, name=name)
            else:
                first[name] = steps
            if kind is None:
                context.add("CB412", source.place(*steps), names=list(ALLOTMENTS), name=text)
