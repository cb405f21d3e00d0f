"""The syntax tree of a composition."""

from typing import NamedTuple

SUBJECT_TO = " ◁ "


class Span(NamedTuple):
    """A stretch of a composition's text; columns from 1, ``end`` is the one after the last."""

    start: int
    end: int


class Argument(NamedTuple):
    """A name that a call hands over, possibly with ``$`` and dots."""

    text: str
    span: Span


class Term(NamedTuple):
    """A controller or program by its name, with what it is called with; ``span`` is its name's."""

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
