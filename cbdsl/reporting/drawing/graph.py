"""A directed graph for people: states, actions, and labelled edges, in whatever format."""

from __future__ import annotations

from enum import StrEnum
from typing import NamedTuple


class Outline(StrEnum):
    """The look of a node."""

    STATE = "state"
    SELECTOR = "selector"
    PATTERN = "pattern"
    ACTION = "action"
    UNUSED = "unused"
    END = "end"


class TextLine(NamedTuple):
    """A line of a label; ``kind`` is a class of the style sheet: name, action, fact or reward."""

    text: str
    kind: str = ""


class Vertex(NamedTuple):
    """A node.

    Attributes:
        key: distinct within the graph.
        shape: its look.
        lines: its label.
        letters: the state that stands above the label as pictograms, one letter per member.
        tooltip: a sentence about it.
        started: whether an arrow without a source leads to it.
        frame: the second frame, ``ending`` or ``ending rewarded``, or empty for none.
        inner: the graph that it runs.
    """

    key: str
    shape: Outline
    lines: tuple[TextLine, ...] = ()
    letters: str = ""
    tooltip: str = ""
    started: bool = False
    frame: str = ""
    inner: Graph | None = None


class Edge(NamedTuple):
    """An edge.

    Attributes:
        source, target: keys of nodes.
        label: beside it.
        weight: its thickness, in [0, 1].
        back: whether it leads back to where all began, and has no say in the layout.
    """

    source: str
    target: str
    label: str = ""
    weight: float = 0.0
    back: bool = False


class Graph(NamedTuple):
    """A graph.

    Attributes:
        name: of the program or policy.
        title: above it.
        nodes: in order.
        edges: the likeliest of a node first.
        members: the letters of a state stand for these.
        programs: those of the members that are programs.
        notes: how to read it.
        across: whether it is laid out from left to right instead of downwards.
    """

    name: str
    title: str
    nodes: tuple[Vertex, ...]
    edges: tuple[Edge, ...]
    members: tuple[str, ...]
    programs: frozenset[str] = frozenset()
    notes: tuple[str, ...] = ()
    across: bool = False
