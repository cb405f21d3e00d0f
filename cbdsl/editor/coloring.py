"""Semantic tokens: kinds of the words in compositions and references, for an editor's colours."""

from __future__ import annotations

import re
from collections.abc import Collection, Iterator
from pathlib import Path
from typing import NamedTuple

from cbdsl.diagnostics.lines import lines_of
from cbdsl.editor.buffers import Buffers
from cbdsl.editor.completions import is_composed, robot_resources, section
from cbdsl.editor.cursor import EnclosingKeys
from cbdsl.types.potential import POTENTIALS

#: Kinds of words, in the protocol's terms: operators are "subject to", functions controllers,
#: namespaces used programs, types potentials, variables resources of the robot.
KINDS_OF_WORDS = ("operator", "function", "namespace", "type", "variable", "parameter")

_WORD = re.compile(r"◁|<\||\$\w+|[A-Za-z][\w.]*")
_RESOURCES = ("feedback", "effector", "reference")


class ColoredWord(NamedTuple):
    """Word and its kind.

    Attributes:
        line: Line, from 0.
        start, end: Columns, from 0, ``end`` exclusive.
        kind: One of ``KINDS_OF_WORDS``.
    """

    line: int
    start: int
    end: int
    kind: str


def colored_words(buffers: Buffers, path: Path) -> Iterator[ColoredWord]:
    """Yield the words of a document that have a kind, from top to bottom."""
    lines = lines_of(buffers.text(path))
    members = dict.fromkeys(section(lines, "controllers"), "function")
    members |= dict.fromkeys(section(lines, "use"), "namespace")
    resources, enclosing = robot_resources(buffers, path), EnclosingKeys(lines)
    for number, line in enumerate(lines):
        # YAML comments begin after a space or at the start. A number sign in quoted text is taken
        # for a comment, too, which only loses some colours.
        code = re.split(r"(?:^|\s)#", line, maxsplit=1)[0]
        for match in _WORD.finditer(code):
            kind = _kind(match[0], enclosing, (number, match.start()), members, resources)
            if kind:
                yield ColoredWord(number, match.start(), match.end(), kind)


def _kind(
    word: str,
    enclosing: EnclosingKeys,
    place: tuple[int, int],
    members: dict[str, str],
    resources: Collection[str],
) -> str:
    """Return the kind of a word at a line and column; empty if it has none."""
    if word in ("◁", "<|"):
        return "operator"
    if word.startswith("$"):
        return "parameter"
    known = word in members or word in POTENTIALS
    if not known and word not in resources:
        return ""
    at = enclosing.cursor(*place)
    if at.on_key:
        is_member = at.steps[:1] in (("controllers",), ("use",)) and len(at.steps) == 1
        return members.get(word, "") if is_member else ""
    if at.key == "potential":
        return "type" if word in POTENTIALS else ""
    if at.key in _RESOURCES:
        return "variable" if word in resources else ""
    return members.get(word, "") if is_composed(at.steps) else ""
