"""The syntax tree of a composition."""

from __future__ import annotations

from dataclasses import dataclass, field

SUBJECT_TO = " ◁ "


@dataclass(frozen=True)
class Span:
    """A stretch of a composition's text; columns from 1, ``end`` is the one after the last."""

    start: int
    end: int


@dataclass(frozen=True)
class Argument:
    """A name that a call hands over, possibly with ``$`` and dots."""

    text: str
    span: Span = field(compare=False)


@dataclass(frozen=True)
class Term:
    """A controller or program by its name, with what it is called with.

    The span of its name is ``span``; spans do not count when terms are compared.
    """

    name: str
    arguments: tuple[Argument, ...]
    span: Span = field(compare=False)

    def __str__(self) -> str:
        if not self.arguments:
            return self.name
        return f"{self.name}({', '.join(argument.text for argument in self.arguments)})"


@dataclass(frozen=True)
class Expression:
    """Terms in written order; the last one has priority."""

    terms: tuple[Term, ...]

    def __str__(self) -> str:
        return SUBJECT_TO.join(str(term) for term in self.terms)


def print_expression(expression: Expression) -> str:
    """The one spelling that is printed: ``◁`` between single spaces."""
    return str(expression)
