"""A checked program as a graph: states, the actions that follow them, and programs within."""

from __future__ import annotations

from typing import NamedTuple

from cbdsl.program.checked import Action, CheckedProgram
from cbdsl.program.dry_run import Coverage, coverage, levels, rewarding


class Box(NamedTuple):
    """An action.

    Attributes:
        name: the action's name.
        lines: what it runs, highest priority first.
        rewarded: whether it can earn the reward.
        patterns: the states that it follows, as the policy writes them.
        inner: the graph of the program that it runs, or ``None``.
    """

    name: str
    lines: tuple[str, ...]
    rewarded: bool
    patterns: tuple[str, ...]
    inner: Graph | None


class Graph(NamedTuple):
    """A program.

    Attributes:
        name: the program's name.
        members: what a state has a letter for, in order.
        boxes: its actions; those that no state leads to, which are for learners, come last.
        background: what runs below every action, or ``None``.
        coverage: how the policy shares the states.
    """

    name: str
    members: tuple[str, ...]
    boxes: tuple[Box, ...]
    background: str | None
    coverage: Coverage


def graph(program: CheckedProgram) -> Graph:
    """The graph of a program, with those of the programs that it uses."""
    boxes = [_box(program, action) for action in program.actions]
    return Graph(
        name=program.name,
        members=program.members,
        boxes=tuple(sorted(boxes, key=lambda box: not box.patterns)),
        background=None if program.background is None else str(program.background),
        coverage=coverage(program),
    )


def _box(program: CheckedProgram, action: Action) -> Box:
    own = [level for level in levels(program, action) if not level.background]
    lines = [
        f"{place}. {level.controller.name}: {level.controller.feedback.name}"
        for place, level in enumerate(own, start=1)
    ]
    if action.program is not None:
        lines = [f"runs program {action.program.name}"]
    return Box(
        name=action.name,
        lines=tuple(lines),
        rewarded=bool(rewarding(action)),
        patterns=tuple(state for state, name in program.policy.items() if name == action.name),
        inner=None if action.program is None else graph(action.program),
    )
