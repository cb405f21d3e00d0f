"""Graph of a program: its state, the patterns of its policy, and the actions they select."""

from __future__ import annotations

from collections.abc import Iterator

from cbdsl.program.checked import Action, CheckedProgram
from cbdsl.program.dry_run import coverage, levels, rewarding
from cbdsl.reporting.drawing.graph import Edge, Graph, Outline, TextLine, Vertex
from cbdsl.reporting.drawing.pictogram import in_words


def program_graph(program: CheckedProgram) -> Graph:
    """Return the graph of a program; the programs that it uses are graphs within its nodes.

    Actions that no pattern selects, which are for learners, come last.
    """
    parts = list(_parts(program))
    below = "" if program.background is None else f"; below: {program.background}"
    return Graph(
        name=program.name,
        title=program.name + below,
        nodes=tuple(part for part in parts if isinstance(part, Vertex)),
        edges=tuple(part for part in parts if isinstance(part, Edge)),
        members=program.members,
        programs=frozenset(action.name for action in program.actions if action.program),
        across=True,
    )


def _parts(program: CheckedProgram) -> Iterator[Vertex | Edge]:
    selector = "state"
    yield Vertex(
        selector, Outline.SELECTOR, (TextLine("state of"), *map(TextLine, program.members))
    )
    unused = []
    for place, action in enumerate(program.actions):
        patterns = [pattern for pattern, name in program.policy.items() if name == action.name]
        for number, pattern in enumerate(patterns):
            key = f"pattern{place}_{number}"
            words = f"{pattern} ({in_words(pattern, program.members)}): {action.name}."
            yield Vertex(key, Outline.PATTERN, letters=pattern, tooltip=words)
            yield from (Edge(selector, key), Edge(key, f"action{place}"))
        if patterns:
            yield _action(program, action, f"action{place}", Outline.ACTION)
            yield Edge(f"action{place}", selector, back=True)
        else:
            unused.append(_action(program, action, f"action{place}", Outline.UNUSED))
    if coverage(program).undecided:
        yield Vertex("other", Outline.PATTERN, (TextLine("any other"),))
        yield Vertex("end", Outline.END, (TextLine("the program ends"),))
        yield from (Edge(selector, "other"), Edge("other", "end"))
    if unused:
        yield Vertex("never", Outline.PATTERN, (TextLine("no state"),))
        yield Edge(selector, "never")
    for node in unused:
        yield from (node, Edge("never", node.key))


def _action(program: CheckedProgram, action: Action, key: str, shape: Outline) -> Vertex:
    own = [level for level in levels(program, action) if not level.background]
    lines = [
        f"{place}. {level.controller.name}: {level.controller.feedback.name}"
        for place, level in enumerate(own, start=1)
    ]
    if action.program is not None:
        lines = [f"runs program {action.program.name}"]
    reward = [TextLine("can be rewarded", "reward")] if rewarding(action) else []
    inner = None if action.program is None else program_graph(action.program)
    label = (TextLine(action.name, "name"), *map(TextLine, lines), *reward)
    return Vertex(key, shape, label, inner=inner)
