"""From the text of a composition to its syntax tree.

    expression: term ("◁" term)*            "c2 ◁ c1" reads "c2 subject to c1"; "<|" is its ASCII
    term: NAME ["(" ARGUMENT ("," ARGUMENT)* ")"]

The language is regular: nothing nests.
"""

from __future__ import annotations

import re
from functools import lru_cache

from cbdsl.language.expression import Argument, Expression, Span, Term

_SPACE = re.compile(r"[ \t\r\n]*")
_NAME = re.compile(r"[A-Za-z][A-Za-z0-9_]*")
_ARGUMENT = re.compile(r"\$?[A-Za-z][A-Za-z0-9_]*(?:\.\$?[A-Za-z0-9_]+)*")
_SUBJECT_TO = re.compile(r"◁|<\|")
_OPEN, _COMMA, _CLOSE = re.compile(r"\("), re.compile(","), re.compile(r"\)")

# Signs that are mistaken for the operator, and signs that point in the opposite direction. The
# patterns are compiled only for an error.
_LOOK_ALIKES = (
    (r"<(?!\|)[<-]*|[⊲◀◂◃⋖«←⟵⇐]", "write '◁', or '<|' in ASCII"),
    (r"\|>|>+|->|[▷⊳▶▸▹⋗»→⟶⇒]", "'b ▷ a' is written 'a ◁ b', or 'a <| b' in ASCII"),
)


class CompositionError(ValueError):
    """Error of a text that is not a composition; ``span`` is the first invalid part."""

    def __init__(self, message: str, span: Span) -> None:
        super().__init__(message)
        self.span = span


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
    return _Scanner(text).expression()


class _Scanner:
    """Text with the position up to which it has been read."""

    def __init__(self, text: str) -> None:
        self._text = text
        self._read = 0

    def expression(self) -> Expression:
        terms = [self._term()]
        while self._take(_SUBJECT_TO):
            terms.append(self._term())
        if self._next() < len(self._text):
            # A term that has arguments cannot be called a second time, so that '(' is not proposed.
            call = () if terms[-1].arguments else ("'('",)
            raise self._look_alike() or self._error(*call, "'◁'", "the end")
        return Expression(tuple(terms))

    def _term(self) -> Term:
        name = self._expect(_NAME, "a name")
        arguments = self._arguments() if self._take(_OPEN) else ()
        return Term(name[0], arguments, _span(name))

    def _arguments(self) -> tuple[Argument, ...]:
        arguments = [self._argument()]
        while self._take(_COMMA):
            arguments.append(self._argument())
        if not self._take(_CLOSE):
            raise self._error("')'", "','")
        return tuple(arguments)

    def _argument(self) -> Argument:
        argument = self._expect(_ARGUMENT, "an argument")
        return Argument(argument[0], _span(argument))

    def _next(self) -> int:
        """Return the index of the first character after the following space."""
        space = _SPACE.match(self._text, self._read)
        return space.end() if space else self._read

    def _take(self, pattern: re.Pattern[str]) -> re.Match[str] | None:
        """Return the next token, and read it, if it matches a pattern."""
        token = pattern.match(self._text, self._next())
        if token is not None:
            self._read = token.end()
        return token

    def _expect(self, pattern: re.Pattern[str], allowed: str) -> re.Match[str]:
        token = self._take(pattern)
        if token is None:
            raise self._error(allowed)
        return token

    def _error(self, *allowed: str) -> CompositionError:
        """Return the error that the next token is none of the allowed ones."""
        wanted, start = " or ".join(allowed), self._next()
        if start == len(self._text):
            # The missing part belongs one column behind the last token, in front of trailing space.
            end = self._read + 1
            return CompositionError(f"expected {wanted} at the end", Span(end, end + 1))
        # The message quotes a whole word such as ``$arm.position``, otherwise a single character.
        token = _SUBJECT_TO.match(self._text, start) or _ARGUMENT.match(self._text, start)
        sign = token[0] if token else self._text[start]
        span = Span(start + 1, start + 1 + len(sign))
        return CompositionError(f"expected {wanted}, found '{sign}'", span)

    def _look_alike(self) -> LookAlikeError | None:
        """Return the error for a look-alike of the operator, if one is next."""
        for pattern, suggestion in _LOOK_ALIKES:
            if sign := re.compile(pattern).match(self._text, self._next()):
                return LookAlikeError(sign[0], suggestion, _span(sign))
        return None


def _span(token: re.Match[str]) -> Span:
    return Span(token.start() + 1, token.end() + 1)
