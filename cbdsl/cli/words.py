"""Command-line words of ``cb``."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

from cbdsl.errors.errors import UsageError

_HELP = ("--help", "-h", "help")


def asks_for_backends(words: Sequence[str]) -> bool:
    """Whether help is asked for where the name of a backend belongs: ``--backend --help``.

    Args:
        words: all that follow ``cb``.

    Raises:
        UsageError: ``--backend`` stands last and names none.
    """
    if words[-1:] == ["--backend"]:
        raise UsageError(f"--backend is given no name (known: {', '.join(_backends())})")
    pairs = pairwise(words)
    return any(before == "--backend" and word in _HELP for before, word in pairs)


def _backends() -> Sequence[str]:
    """Return the names of all backends."""
    from cbdsl.cli.simulation import needing_simulation

    with needing_simulation():
        from cbdsl.backends.backend import BACKENDS
    return BACKENDS.names()


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
