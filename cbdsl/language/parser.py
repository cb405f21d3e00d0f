"""From the text of a composition to its syntax tree.

The language, with any white space between its words::

    expression = term { ("◁" | "<|") term }
    term       = name [ "(" argument { "," argument } ")" ]
    name       = letter { letter | digit | "_" }
    argument   = word { "." word }     where a word may begin with "$"

``c2 ◁ c1`` reads "c2 subject to c1": the rightmost term has priority.
"""

from __future__ import annotations

import re

from cbdsl.language.expression import Argument, Expression, Span, Term

_SPACE = re.compile(r"[ \t\r\n]*")
_NAME = re.compile(r"[A-Za-z][A-Za-z0-9_]*")
_ARGUMENT = re.compile(r"\$?[A-Za-z][A-Za-z0-9_]*(?:\.\$?[A-Za-z0-9_]+)*")
_SUBJECT_TO = re.compile(r"◁|<\|")
_OPEN, _COMMA, _CLOSE = re.compile(r"\("), re.compile(","), re.compile(r"\)")
# Characters that people take for the subject-to sign.
_LOOKALIKES = frozenset("<⊲◀◂◃⋖«←⟵⇐")


class CompositionError(ValueError):
    """A text is no composition; ``span`` says where it stops being one."""

    def __init__(self, message: str, span: Span) -> None:
        super().__init__(message)
        self.span = span


def parse(text: str) -> Expression:
    """Read a composition such as ``posture ◁ reach(sat_10, right_arm)``.

    Raises:
        CompositionError: the text is no composition; it knows where.
    """
    return _Parser(text).expression()


class _Parser:
    """Recursive descent, one method per rule."""

    def __init__(self, text: str) -> None:
        self._text = text
        self._at = 0
        self._take(_SPACE)

    def expression(self) -> Expression:
        terms = [self._term()]
        while self._take(_SUBJECT_TO):
            terms.append(self._term())
        if self._at < len(self._text):
            call = "" if terms[-1].arguments else "'(' or "
            raise self._unexpected(f"{call}'◁' or the end")
        return Expression(tuple(terms))

    def _term(self) -> Term:
        name = self._require(_NAME, "a name")
        arguments = self._arguments() if self._take(_OPEN) else ()
        return Term(name[0], arguments, _span(name))

    def _arguments(self) -> tuple[Argument, ...]:
        found = [self._argument()]
        while self._take(_COMMA):
            found.append(self._argument())
        self._require(_CLOSE, "')' or ','")
        return tuple(found)

    def _argument(self) -> Argument:
        match = self._require(_ARGUMENT, "an argument")
        return Argument(match[0], _span(match))

    def _take(self, pattern: re.Pattern[str]) -> re.Match[str] | None:
        """What matches here, if anything; the white space after it is passed over."""
        match = pattern.match(self._text, self._at)
        if match:
            space = _SPACE.match(self._text, match.end())
            self._at = space.end() if space else match.end()
        return match

    def _require(self, pattern: re.Pattern[str], allowed: str) -> re.Match[str]:
        match = self._take(pattern)
        if match is None:
            raise self._unexpected(allowed)
        return match

    def _unexpected(self, allowed: str) -> CompositionError:
        if self._at == len(self._text):
            end = len(self._text.rstrip()) + 1
            return CompositionError(f"it ends where {allowed} should follow", Span(end, end + 1))
        word = _ARGUMENT.match(self._text, self._at) or _SUBJECT_TO.match(self._text, self._at)
        found = word[0] if word else self._text[self._at]
        if found in _LOOKALIKES:
            allowed = "'◁' or its ASCII spelling '<|'"
        span = Span(self._at + 1, self._at + 1 + len(found))
        return CompositionError(f"'{found}' where {allowed} should be", span)


def _span(match: re.Match[str]) -> Span:
    return Span(match.start() + 1, match.end() + 1)
