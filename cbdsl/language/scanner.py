"""Scanner of short texts: tokens, and errors with their places."""

from __future__ import annotations

import re

from cbdsl.language.expression import Span

_SPACE = re.compile(r"[ \t\r\n]*")
_WORD = re.compile(r"\$?[A-Za-z][A-Za-z0-9_]*(?:\.\$?[A-Za-z0-9_]+)*|◁|<\|")


class CompositionError(ValueError):
    """Error of a text that is not a composition; ``span`` is the first invalid part."""

    def __init__(self, message: str, span: Span) -> None:
        super().__init__(message)
        self.span = span


class Scanner:
    """Text with the position up to which it has been read."""

    def __init__(self, text: str) -> None:
        self.text = text
        self.read = 0

    @property
    def next(self) -> int:
        """Index of the first character after the following space."""
        space = _SPACE.match(self.text, self.read)
        return space.end() if space else self.read

    @property
    def is_at_end(self) -> bool:
        """True if only space follows."""
        return self.next == len(self.text)

    def take(self, pattern: re.Pattern[str]) -> re.Match[str] | None:
        """Return the next token, and read it, if it matches a pattern."""
        token = pattern.match(self.text, self.next)
        if token is not None:
            self.read = token.end()
        return token

    def expect(self, pattern: re.Pattern[str], allowed: str) -> re.Match[str]:
        """Return the next token, and read it.

        Raises:
            CompositionError: It does not match the pattern.
        """
        token = self.take(pattern)
        if token is None:
            raise self.error(allowed)
        return token

    def error(self, *allowed: str) -> CompositionError:
        """Return the error that the next token is none of the allowed ones."""
        wanted, start = " or ".join(allowed), self.next
        if start == len(self.text):
            # The missing part belongs one column behind the last token, in front of trailing space.
            end = self.read + 1
            return CompositionError(f"expected {wanted} at the end", Span(end, end + 1))
        # The message quotes a whole word such as ``$arm.position``, otherwise a single character.
        token = _WORD.match(self.text, start)
        sign = token[0] if token else self.text[start]
        return CompositionError(
            f"expected {wanted}, found '{sign}'", Span(start + 1, start + 1 + len(sign))
        )


def span_of(token: re.Match[str]) -> Span:
    """Return the span of a token."""
    return Span(token.start() + 1, token.end() + 1)
