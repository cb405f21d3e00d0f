"""The kinds of resources that parameters of a program may stand for."""

from __future__ import annotations

from cbdsl.checking.context import ProgramContext, Steps
from cbdsl.types.allotment import ALLOTMENTS, allotment


def check_allotments(context: ProgramContext) -> None:
    """Check that a program lets parameters of its own be replaced, each once, by a known kind."""
    document, source = context.document, context.source
    parameters = source.declared(document.parameters, "parameters")
    first: dict[str, Steps] = {}
    for group, wanted in document.resources.items():
        for name, text in wanted.items():
            steps: Steps = ("resources", group, name)
            if name not in parameters:
                context.add(
                    "CB402", source.key(*steps), names=sorted(parameters), name=name, hint=""
                )
            elif name in first:
                related = [(source.key(*first[name]), "it is replaced here")]
                context.add("CB411", source.key(*steps), related=related, name=name)
            else:
                first[name] = steps
            if allotment(text) is None:
                context.add("CB412", source.place(*steps), names=list(ALLOTMENTS), name=text)
