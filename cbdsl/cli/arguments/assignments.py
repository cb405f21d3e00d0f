"""Values given as ``--with name=value``."""

from __future__ import annotations

from collections.abc import Iterable

from cbdsl.diagnostics.errors import UsageError
from cbdsl.types.role import ROBOT


def read_assignments(
    texts: Iterable[str], option: str = "--with", robot: str | None = None
) -> dict[str, str]:
    """Return the values by name.

    Args:
        texts: Assignments.
        option: Option that gave them.
        robot: Robot of a program with roles, which is one more value.

    Raises:
        UsageError: A text is not an assignment, or two texts assign the same name.
    """
    values: dict[str, str] = {} if robot is None else {ROBOT: robot}
    for text in texts:
        # The first sign separates, so that a value may contain further ones.
        name, equals, value = text.partition("=")
        if not (name and equals and value):
            raise UsageError(f"{option} {text}: expected name=value")
        if name in values:
            raise UsageError(f"{option} {text}: '{name}' is given twice")
        values[name] = value
    return values
