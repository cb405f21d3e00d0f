"""Entries of a section of a document, with the omitted ones as unknown."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import TypeVar

from cbdsl.diagnostics.outcome import UNKNOWN, Outcome
from cbdsl.yaml_text.broken import Broken, Steps

T = TypeVar("T")


class Declared(Mapping[str, Outcome[T]]):
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

    @property
    def known(self) -> Mapping[str, T]:
        """Entries without the unknown ones."""
        return self._entries

    def __getitem__(self, name: str) -> Outcome[T]:
        if name in self._entries:
            return self._entries[name]
        if self._broken.touches((*self._steps, name)):
            return UNKNOWN
        raise KeyError(name)

    def __iter__(self) -> Iterator[str]:
        return iter(self._entries)

    def __len__(self) -> int:
        return len(self._entries)
