"""Syntax tree of a composition."""

from typing import NamedTuple

SUBJECT_TO = " ◁ "


class Span(NamedTuple):
    """Span of a composition's text; columns from 1, ``end`` exclusive."""

    start: int
    end: int


class Argument(NamedTuple):
    """Argument of a call: a name, possibly with ``$`` and dots."""

    text: str
    span: Span


class Term(NamedTuple):
    """Controller or program by name, with the arguments of a call; ``span`` is that of the name."""

    name: str
    arguments: tuple[Argument, ...]
    span: Span

    def __str__(self) -> str:
        if not self.arguments:
            return self.name
        return f"{self.name}({', '.join(argument.text for argument in self.arguments)})"


class Expression(NamedTuple):
    """Terms in written order; the last one has priority."""

    terms: tuple[Term, ...]

    def __str__(self) -> str:
        return SUBJECT_TO.join(str(term) for term in self.terms)
