"""Legible forms of document texts, for quotation in messages."""

from __future__ import annotations

import re
from collections.abc import Callable

# Characters that move a terminal's cursor, break a line, or show nothing at all.
# The pattern is compiled on the first diagnostic.
_UNSEEN = (
    "[\x00-\x1f\x7f-\x9f\u200b\u200e\u200f\u2028-\u202e\u2060\u2066-\u2069\ufeff\ud800-\udfff]"
)
_LONGEST = 400


def seen(text: str, instead: Callable[[str], str]) -> str:
    """Return a text with a replacement for each unprintable character."""
    return re.sub(_UNSEEN, lambda unseen: instead(unseen[0]), text)


def legible(text: str) -> str:
    """Return a text on one line, shortened, with unprintable characters written as escapes."""
    if len(text) > _LONGEST:
        # The beginning and the end identify a text better than its beginning alone.
        text = f"{text[: _LONGEST // 2]} … {text[-_LONGEST // 4 :]}"
    return one_line(text)


def encoded(text: str) -> bytes:
    """Return a text in UTF-8; a lone surrogate, which UTF-8 lacks, becomes its escape in JSON."""
    return text.encode("utf-8", "backslashreplace")


def one_line(text: str) -> str:
    """Return a text on one line, with unprintable characters written as escapes."""
    if text.isprintable():
        return text
    return seen(text, lambda unseen: unseen.encode("unicode_escape").decode())
