"""Syntax error as libyaml reports it, and the probable mistake behind it."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from typing import NamedTuple

import yaml

NO_COLON = "could not find expected ':'"
NO_MAPPING = "mapping values are not allowed in this context"
NO_KEY = "did not find expected key"
NO_ITEM = "did not find expected '-' indicator"
NO_CONTENT = "did not find expected node content"
NO_START = "did not find expected <document start>"
NO_DIRECTIVE = "could not find expected directive name"
NO_TOKEN = "found character that cannot start any token"
ALIAS = "while scanning an alias"
# Errors that libyaml reports behind the mistake.
OPEN = "found unexpected end of stream"
_LATE = (NO_COLON, OPEN)
OPENED = {
    "did not find expected ',' or ']'": ("[", "]"),
    "did not find expected ',' or '}'": ("{", "}"),
}
_BEGINS = re.compile(r"\s*(?:- |---|\.\.\.|(?:- +)*['\"]?[\w$*-]+['\"]?:(?:\s|$))")


class TextCorrection(NamedTuple):
    """Probable mistake in a text.

    Attributes:
        problem: Message, as a clause.
        line: Line number, from 1.
        column: Column of its first character, from 1.
        code: Code in the catalogue of diagnostics.
        lines: Corrected lines by number from 1, if the correction is certain.
    """

    problem: str
    line: int
    column: int
    code: str = "CB104"
    lines: Mapping[int, str] = {}

    def mended(self, lines: Sequence[str]) -> list[str]:
        """Return all lines of the text with the mistake corrected."""
        return [self.lines.get(number, line) for number, line in enumerate(lines, 1)]


class ReportedError(NamedTuple):
    """Syntax error as libyaml reports it.

    Attributes:
        problem: Message of libyaml.
        context: Context that libyaml reports.
        lines: Lines of the text.
        line: Line number, from 1.
        column: Column, from 1.
        opened: Line and column at which the enclosing structure begins, from 1.
    """

    problem: str
    context: str
    lines: Sequence[str]
    line: int
    column: int
    opened: tuple[int, int]

    @property
    def text(self) -> str:
        """Text of the line."""
        return self.lines[self.line - 1]

    @property
    def before(self) -> str:
        """Text in front of the place in its line."""
        return self.text[: self.column - 1]

    @property
    def rest(self) -> str:
        """Text from the place to the end of its line."""
        return self.text[self.column - 1 :]

    @property
    def above(self) -> int:
        """Number of the nearest non-blank, non-comment line above, or 0."""
        numbers = range(self.line - 1, 0, -1)
        return next((n for n in numbers if not re.match(r"\s*(#|$)", self.lines[n - 1])), 0)

    @property
    def at_end(self) -> bool:
        """True if only comments and empty lines follow in the text."""
        left = [self.rest, *self.lines[self.line :]]
        return all(re.match(r"\s*(#|$)", line) for line in left)

    @property
    def is_outside(self) -> bool:
        """True if an entry begins on this line and is indented too little to be within brackets."""
        row = self.opened[0]
        indents = [len(text) - len(text.lstrip()) for text in (self.text, self.lines[row - 1])]
        return row < self.line and indents[0] <= indents[1] and _BEGINS.match(self.text) is not None

    def instead(self, line: str) -> Mapping[int, str]:
        """Return the correction that replaces this line by another."""
        return {self.line: line}


def reported_error(error: yaml.MarkedYAMLError, lines: Sequence[str]) -> ReportedError:
    problem = error.problem or error.context or "no YAML"
    start = error.context_mark or error.problem_mark
    # A key that lacks its colon is noticed only on the next line, an open quote at the end.
    mark = start if problem in _LATE else error.problem_mark or start
    place = (mark.line + 1, mark.column + 1) if mark else (1, 1)
    opened = (start.line + 1, start.column + 1) if start else place
    return ReportedError(problem, error.context or "", lines, *place, opened)
