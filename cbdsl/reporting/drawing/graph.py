"""Directed graph for display: states, actions and labelled edges, independent of the format."""

from __future__ import annotations

from enum import StrEnum
from typing import NamedTuple


class Outline(StrEnum):
    """Outline of a node."""

    STATE = "state"
    SELECTOR = "selector"
    PATTERN = "pattern"
    ACTION = "action"
    END = "end"


class TextLine(NamedTuple):
    """Line of a label; ``kind`` is a class of the style sheet: name, action, fact or reward."""

    text: str
    kind: str = ""


class Vertex(NamedTuple):
    """Node of a graph.

    Attributes:
        key: Key of the node, distinct within the graph.
        shape: Outline of the node.
        lines: Lines of the label.
        letters: State shown above the label as pictograms, one letter per member.
        tooltip: Sentence about the node.
        started: True if an arrow without a source leads to it.
        frame: Second frame, ``ending`` or ``ending rewarded``, or empty for none.
        inner: Graph that the node runs.
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
    """Edge of a graph.

    Attributes:
        source, target: Keys of nodes.
        label: Text beside the edge.
        weight: Thickness, in [0, 1].
    """

    source: str
    target: str
    label: str = ""
    weight: float = 0.0


class Graph(NamedTuple):
    """Directed graph.

    Attributes:
        name: Name of the program or policy.
        title: Text above the graph.
        nodes: Nodes in order.
        edges: Edges, the most likely one of a node first.
        members: Members behind the letters of a state.
        programs: Members that are programs.
        notes: Notes for reading the graph.
    """

    name: str
    title: str
    nodes: tuple[Vertex, ...]
    edges: tuple[Edge, ...]
    members: tuple[str, ...]
    programs: frozenset[str] = frozenset()
    notes: tuple[str, ...] = ()
