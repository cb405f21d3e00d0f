"""Error value in place of a faulty part that was left out of the document.

Like the error types of compilers, it suppresses dependent diagnostics: a fault is reported only
at its own place.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Final, TypeVar

from cbdsl.yaml_text.broken import Broken, Steps

T = TypeVar("T")


class Unknown(str):
    """Placeholder for an unknown name or named object; equal only to itself."""

    __slots__ = ()
    __hash__ = object.__hash__

    # As a text it would equal the name "unknown" of an existing part.
    def __eq__(self, other: object) -> bool:
        return self is other

    def __ne__(self, other: object) -> bool:
        return self is not other


UNKNOWN: Final = Unknown("unknown")


class Declared(Mapping[str, T | Unknown]):
    """Entries of a section by name, with ``UNKNOWN`` for each omitted entry.

    Iteration skips unknown entries.

    Args:
        entries: Entries without faults.
        broken: Omitted parts of the document.
        steps: Path of the section.
    """

    def __init__(self, entries: Mapping[str, T], broken: Broken, steps: Steps) -> None:
        self._entries, self._broken, self._steps = entries, broken, steps

    def extended(self, entries: Mapping[str, T]) -> Declared[T]:
        """Return these entries extended by others, which override entries of the same name."""
        return Declared({**self._entries, **entries}, self._broken, self._steps)

    def __getitem__(self, name: str) -> T | Unknown:
        if name in self._entries:
            return self._entries[name]
        if self._broken.touches((*self._steps, name)):
            return UNKNOWN
        raise KeyError(name)

    def __iter__(self) -> Iterator[str]:
        return iter(self._entries)

    def __len__(self) -> int:
        return len(self._entries)
