"""Outcome of a look-up: a value, or unknown because of a diagnostic that is reported at its cause.

Like the error types of compilers, the unknown outcome suppresses dependent diagnostics: a fault is
reported only at its own place.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING, Final, TypeAlias, TypeVar, final

T = TypeVar("T")


# Documents with faults hold the placeholder where a model requires a text, so that it is one. Type
# checkers see no text, and refuse a look-up as a text until it is known.
if TYPE_CHECKING:

    class _Text:
        def __init__(self, text: str) -> None: ...

else:
    _Text = str


@final
class Unknown(_Text):
    """Placeholder for an unknown name or value; equal only to itself."""

    __slots__ = ()
    __hash__ = object.__hash__

    # As a text it would equal the name "unknown" of an existing part.
    def __eq__(self, other: object) -> bool:
        return self is other

    def __ne__(self, other: object) -> bool:
        return self is not other


UNKNOWN: Final = Unknown("unknown")

Outcome: TypeAlias = T | Unknown
"""Value of a look-up, or ``UNKNOWN`` if a diagnostic says why there is none."""


def all_known(outcomes: Iterable[Outcome[T]]) -> Outcome[list[T]]:
    """Return the values of some look-ups; unknown if one of them is."""
    values = []
    for outcome in outcomes:
        if isinstance(outcome, Unknown):
            return UNKNOWN
        values.append(outcome)
    return values
