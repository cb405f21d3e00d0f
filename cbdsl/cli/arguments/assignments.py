"""Values given as ``--with name=value``."""

from __future__ import annotations

from collections.abc import Iterable

from cbdsl.diagnostics.errors import UsageError


def read_assignments(texts: Iterable[str], option: str = "--with") -> dict[str, str]:
    """Return the values by name.

    Raises:
        UsageError: A text is not an assignment, or two texts assign the same name.
    """
    values: dict[str, str] = {}
    for text in texts:
        # The first sign separates, so that a value may contain further ones.
        name, equals, value = text.partition("=")
        if not (name and equals and value):
            raise UsageError(f"{option} {text}: expected name=value")
        if name in values:
            raise UsageError(f"{option} {text}: '{name}' is given twice")
        values[name] = value
    return values
