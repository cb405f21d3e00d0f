"""From the text of a composition to its syntax tree."""

from __future__ import annotations

import re
from functools import cache, lru_cache
from typing import TYPE_CHECKING, Any

from cbdsl.language.expression import Argument, Expression, Span, Term
from cbdsl.language.regular import read_composition

if TYPE_CHECKING:
    from lark import Lark, Token, Tree
    from lark.exceptions import UnexpectedInput

_WORDS = {
    "NAME": "a name",
    "ARGUMENT": "an argument",
    "_SUBJECT_TO": "'◁'",
    "LPAR": "'('",
    "RPAR": "')'",
    "COMMA": "','",
    "$END": "the end",
}
# What people take for the subject-to sign, and what points the other way.
_LOOK_ALIKE = r"<(?!\|)[<-]*|[⊲◀◂◃⋖«←⟵⇐]"
_TURNED = r"\|>|>+|->|[▷⊳▶▸▹⋗»→⟶⇒]"


class CompositionError(ValueError):
    """A text is no composition; ``span`` says where it stops being one."""

    def __init__(self, message: str, span: Span) -> None:
        super().__init__(message)
        self.span = span


class LookAlikeError(CompositionError):
    """There is a sign where an operator should be, and it is not the operator.

    Attributes:
        found: the sign.
        meant: what to write instead, as a clause.
    """

    def __init__(self, found: str, meant: str, span: Span) -> None:
        super().__init__(f"'{found}' is not the operator: {meant}", span)
        self.found = found
        self.meant = meant


@cache
def _grammar() -> Lark:
    import lark
    from lark import Lark

    from cbdsl.language import tables

    if lark.__version__ != tables.LARK:
        return Lark.open("composition.lark", rel_to=__file__, parser="lalr", start="expression")
    # Stated to take a file, it takes what would be in the file as well.
    parser: Lark = Lark.load(tables.TABLES)
    return parser


@lru_cache(maxsize=1_000)
def parse(text: str) -> Expression:
    """Read a composition such as ``posture ◁ reach(sat_10, right_arm)``.

    Raises:
        CompositionError: the text is no composition; it knows where.
    """
    return read_composition(text) or parse_by_grammar(text)


def parse_by_grammar(text: str) -> Expression:
    """The same by the grammar alone, which tells why a text is no composition.

    Raises:
        CompositionError: as ``parse``.
    """
    from lark.exceptions import UnexpectedInput

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
    from lark.exceptions import UnexpectedToken

    allowed = " or ".join(sorted({_WORDS[name] for name in _expected(error)}))
    if isinstance(error, UnexpectedToken) and error.token.type == "$END":
        end = len(text.rstrip()) + 1
        return CompositionError(f"it ends where {allowed} should follow", Span(end, end + 1))
    start = (error.pos_in_stream or 0) + 1
    look_alike = _look_alike(text, start) if "_SUBJECT_TO" in _expected(error) else None
    if look_alike is not None:
        return look_alike
    found = str(error.token) if isinstance(error, UnexpectedToken) else text[start - 1]
    return CompositionError(f"'{found}' where {allowed} should be", Span(start, start + len(found)))


def _look_alike(text: str, start: int) -> LookAlikeError | None:
    """The operator that was meant by what stands at a column, from 1."""
    for pattern, meant in (
        (_LOOK_ALIKE, "write '◁', or '<|' in ASCII"),
        (_TURNED, "'b ▷ a' is written 'a ◁ b', or 'a <| b' in ASCII"),
    ):
        # Compiled here: only a fault needs them.
        if sign := re.compile(pattern).match(text, start - 1):
            return LookAlikeError(sign[0], meant, Span(start, sign.end() + 1))
    return None


def _expected(error: UnexpectedInput) -> set[str]:
    from lark.exceptions import UnexpectedCharacters, UnexpectedToken

    if isinstance(error, UnexpectedCharacters):
        return set(error.allowed or ())
    return set(error.accepts or error.expected) if isinstance(error, UnexpectedToken) else set()
