"""The words that ``cb`` is called with."""

from __future__ import annotations

from collections.abc import Sequence

from cbdsl.errors.errors import UsageError


def require_words(words: Sequence[str]) -> None:
    """Refuse an empty word, which is most often a variable of a shell that nobody has set.

    As a path it would be the working folder, and as a name the default.

    Args:
        words: all that follow ``cb``.

    Raises:
        UsageError: one is empty, or an option's text after ``=`` is.
    """
    for before, word in zip(["cb", *words], words, strict=False):
        option, equals, text = word.partition("=")
        if option.startswith("--") and equals and not text:
            raise UsageError(f"{option} is given an empty text")
        if not word:
            place = f"{before} is given" if before.startswith("--") else f"after '{before}' stands"
            raise UsageError(f"{place} an empty text")
