"""From the text of a composition to its syntax tree."""

from __future__ import annotations

from functools import cache
from typing import Any

import lark
from lark import Lark, Token, Tree
from lark.exceptions import UnexpectedCharacters, UnexpectedInput, UnexpectedToken

from cbdsl.language import tables
from cbdsl.language.expression import Argument, Expression, Span, Term

_WORDS = {
    "NAME": "a name",
    "ARGUMENT": "an argument",
    "_SUBJECT_TO": "'◁'",
    "LPAR": "'('",
    "RPAR": "')'",
    "COMMA": "','",
    "$END": "the end",
}
# Characters that people take for the subject-to sign.
_LOOKALIKES = frozenset("<⊲◀◂◃⋖«←⟵⇐")


class CompositionError(ValueError):
    """A text is no composition; ``span`` says where it stops being one."""

    def __init__(self, message: str, span: Span) -> None:
        super().__init__(message)
        self.span = span


@cache
def _grammar() -> Lark:
    if lark.__version__ != tables.LARK:
        return Lark.open("composition.lark", rel_to=__file__, parser="lalr", start="expression")
    # Stated to take a file, it takes what would be in the file as well.
    parser: Lark = Lark.load(tables.TABLES)
    return parser


def parse(text: str) -> Expression:
    """Read a composition such as ``posture ◁ reach(sat_10, right_arm)``.

    Raises:
        CompositionError: the text is no composition; it knows where.
    """
    try:
        return _expression(_grammar().parse(text))
    except UnexpectedInput as error:
        raise _located(error, text) from None


def _expression(tree: Tree[Token]) -> Expression:
    return Expression(tuple(_term(term) for term in tree.children))


def _term(tree: Any) -> Term:
    name, arguments = tree.children
    given = () if arguments is None else tuple(_argument(token) for token in arguments.children)
    return Term(str(name), given, _span(name))


def _argument(token: Token) -> Argument:
    return Argument(str(token), _span(token))


def _span(token: Token) -> Span:
    start = (token.start_pos or 0) + 1
    return Span(start, start + len(token))


def _located(error: UnexpectedInput, text: str) -> CompositionError:
    allowed = " or ".join(sorted({_WORDS[name] for name in _expected(error)}))
    if isinstance(error, UnexpectedToken) and error.token.type == "$END":
        end = len(text.rstrip()) + 1
        return CompositionError(f"it ends where {allowed} should follow", Span(end, end + 1))
    start = (error.pos_in_stream or 0) + 1
    found = str(error.token) if isinstance(error, UnexpectedToken) else text[start - 1]
    if found in _LOOKALIKES:
        allowed = "'◁' or its ASCII spelling '<|'"
    return CompositionError(f"'{found}' where {allowed} should be", Span(start, start + len(found)))


def _expected(error: UnexpectedInput) -> set[str]:
    if isinstance(error, UnexpectedCharacters):
        return set(error.allowed or ())
    return set(error.accepts or error.expected) if isinstance(error, UnexpectedToken) else set()
