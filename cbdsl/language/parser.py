"""From the text of a composition to its syntax tree.

    expression: term ("◁" term)*            "c2 ◁ c1" reads "c2 subject to c1"; "<|" is its ASCII
    term: NAME ["(" ARGUMENT ("," ARGUMENT)* ")"]     an argument is a name or a quantity

The language is regular: nothing nests.
"""

from __future__ import annotations

import re
from functools import lru_cache

from cbdsl.language.expression import Argument, Expression, Span, Term
from cbdsl.language.scanner import CompositionError, Scanner, span_of

_NAME = re.compile(r"[A-Za-z][A-Za-z0-9_]*")
_ARGUMENT = re.compile(
    r"\$?[A-Za-z][A-Za-z0-9_]*(?:\.\$?[A-Za-z0-9_]+)*"
    r"|[+-]?\.?[0-9](?:[^,()◁<]*[^,()◁<\s])?"
)
_SUBJECT_TO = re.compile(r"◁|<\|")
_OPEN, _COMMA, _CLOSE = re.compile(r"\("), re.compile(","), re.compile(r"\)")

# Signs that are mistaken for the operator, and signs that point in the opposite direction. The
# patterns are compiled only for an error.
_LOOK_ALIKES = (
    (r"<(?!\|)[<-]*|[⊲◀◂◃⋖«←⟵⇐]", "write '◁', or '<|' in ASCII"),
    (r"\|>|>+|->|[▷⊳▶▸▹⋗»→⟶⇒]", "'b ▷ a' is written 'a ◁ b', or 'a <| b' in ASCII"),
)


class LookAlikeError(CompositionError):
    """Sign that is mistaken for the operator.

    Attributes:
        sign: Sign as written.
        suggestion: Remedy, as a clause.
    """

    def __init__(self, sign: str, suggestion: str, span: Span) -> None:
        super().__init__(f"'{sign}' is not the subject-to operator: {suggestion}", span)
        self.sign = sign
        self.suggestion = suggestion


# Actions, policies and conditions repeat the same texts. Syntax trees are immutable, so that one
# scan per text is enough.
@lru_cache(maxsize=1_000)
def parse(text: str) -> Expression:
    """Read a composition such as ``posture ◁ reach(sat_10, right_arm)``.

    Raises:
        CompositionError: The text is not a composition; the error has the place.
    """
    scanner = Scanner(text)
    terms = [read_term(scanner)]
    while scanner.take(_SUBJECT_TO):
        terms.append(read_term(scanner))
    if not scanner.is_at_end:
        # A term that has arguments cannot be called a second time, so that '(' is not proposed.
        call = () if terms[-1].arguments else ("'('",)
        raise _look_alike(scanner) or scanner.error(*call, "'◁'", "the end")
    return Expression(tuple(terms))


def read_term(scanner: Scanner) -> Term:
    """Read a name with its arguments, if any.

    Raises:
        CompositionError: There is none; the error has the place.
    """
    name = scanner.expect(_NAME, "a name")
    arguments = _arguments(scanner) if scanner.take(_OPEN) else ()
    return Term(name[0], arguments, span_of(name))


def _arguments(scanner: Scanner) -> tuple[Argument, ...]:
    arguments = [_argument(scanner)]
    while scanner.take(_COMMA):
        arguments.append(_argument(scanner))
    if not scanner.take(_CLOSE):
        raise scanner.error("')'", "','")
    return tuple(arguments)


def _argument(scanner: Scanner) -> Argument:
    argument = scanner.expect(_ARGUMENT, "an argument")
    return Argument(argument[0], span_of(argument))


def _look_alike(scanner: Scanner) -> LookAlikeError | None:
    """Return the error for a look-alike of the operator, if one is next."""
    for pattern, suggestion in _LOOK_ALIKES:
        if sign := re.compile(pattern).match(scanner.text, scanner.next):
            return LookAlikeError(sign[0], suggestion, span_of(sign))
    return None
