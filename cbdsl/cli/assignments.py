"""Values given as ``--with name=value``."""

from __future__ import annotations

from collections.abc import Iterable

from cbdsl.errors.errors import UsageError


def read_assignments(texts: Iterable[str], option: str = "--with") -> dict[str, str]:
    """Value by name.

    Raises:
        UsageError: a text is no assignment, or two are for the same name.
    """
    values: dict[str, str] = {}
    for text in texts:
        name, equals, value = text.partition("=")
        if not (name and equals and value):
            raise UsageError(f"{option} {text}: expected name=value")
        if name in values:
            raise UsageError(f"{option} {text}: '{name}' is given twice")
        values[name] = value
    return values
