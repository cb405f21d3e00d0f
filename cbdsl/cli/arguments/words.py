"""Command-line words of ``cb``."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

from cbdsl.diagnostics.errors import UsageError

_HELP = ("--help", "-h", "help")


def asks_for_backends(words: Sequence[str]) -> bool:
    """Return whether a word for help stands in place of a backend: ``--backend --help``.

    Args:
        words: Command-line words after ``cb``.

    Raises:
        UsageError: ``--backend`` is the last word and has no name.
    """
    if words[-1:] == ["--backend"]:
        raise UsageError(f"--backend is given no name (known: {', '.join(_backends())})")
    # Without this case, `--help` would be an unknown backend.
    pairs = pairwise(words)
    return any(before == "--backend" and word in _HELP for before, word in pairs)


def _backends() -> Sequence[str]:
    """Return the names of all backends."""
    from cbdsl.cli.episodes.simulation import needing_simulation

    with needing_simulation():
        from cbdsl.backends.backend import BACKENDS
    return BACKENDS.names()


def require_words(words: Sequence[str]) -> None:
    """Reject an empty word, which is most often an unset variable of a shell.

    An empty path would be the working folder, and an empty name the default.

    Args:
        words: Command-line words after ``cb``.

    Raises:
        UsageError: A word is empty, or the text of an option after ``=`` is.
    """
    for before, word in zip(["cb", *words], words, strict=False):
        option, equals, text = word.partition("=")
        if option.startswith("--") and equals and not text:
            raise UsageError(f"{option} is given an empty text")
        # `cb run "$PROGRAM"` reaches this with an unset variable.
        if not word:
            place = f"{before} is given" if before.startswith("--") else f"after '{before}' stands"
            raise UsageError(f"{place} an empty text")
