"""Compositions nest nothing: what is one can be read by regular expressions.

To import lark takes a fifth of the time of ``cb validate``. What is no composition is left to it,
which knows why.
"""

from __future__ import annotations

import re

from cbdsl.language.expression import Argument, Expression, Span, Term

# The same as in composition.lark.
_SPACE = r"[ \t\r\n]*"
_NAME = r"[A-Za-z][A-Za-z0-9_]*"
_ARGUMENT = rf"\$?{_NAME}(?:\.\$?[A-Za-z0-9_]+)*"
_ARGUMENTS = rf"{_ARGUMENT}{_SPACE}(?:,{_SPACE}{_ARGUMENT}{_SPACE})*"
_TERM = re.compile(rf"{_SPACE}({_NAME}){_SPACE}(?:\({_SPACE}({_ARGUMENTS})\){_SPACE})?")
_EACH_ARGUMENT = re.compile(_ARGUMENT)
_SUBJECT_TO = re.compile(r"◁|<\|")


def read_composition(text: str) -> Expression | None:
    """The syntax tree of a composition, or ``None`` where the text is none."""
    terms = []
    position = 0
    while found := _TERM.match(text, position):
        terms.append(_term(found))
        if found.end() == len(text):
            return Expression(tuple(terms))
        operator = _SUBJECT_TO.match(text, found.end())
        if operator is None:
            return None
        position = operator.end()
    return None


def _term(found: re.Match[str]) -> Term:
    given: tuple[Argument, ...] = ()
    if found[2] is not None:
        each = _EACH_ARGUMENT.finditer(found.string, *found.span(2))
        given = tuple(Argument(match[0], _span(match)) for match in each)
    return Term(found[1], given, Span(found.start(1) + 1, found.end(1) + 1))


def _span(found: re.Match[str]) -> Span:
    return Span(found.start() + 1, found.end() + 1)
