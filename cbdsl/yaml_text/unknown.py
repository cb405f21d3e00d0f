"""The error value: it stands for what is written, and was left out because it is faulty.

As the error types of compilers do, it silences whatever depends on it: the fault is reported where
it stands, and nowhere else.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Final, TypeVar

from cbdsl.yaml_text.broken import Broken, Steps

T = TypeVar("T")


class Unknown(str):
    """A name, or what has a name, that nobody can know; equal to nothing but itself."""

    __slots__ = ()
    __hash__ = object.__hash__

    def __eq__(self, other: object) -> bool:
        return self is other

    def __ne__(self, other: object) -> bool:
        return self is not other


UNKNOWN: Final = Unknown("unknown")


class Declared(Mapping[str, T | Unknown]):
    """The entries of a section by name, with ``UNKNOWN`` for each that was left out.

    Iteration passes over what is unknown.

    Args:
        entries: those without faults.
        broken: the parts that were left out.
        steps: path of the section.
    """

    def __init__(self, entries: Mapping[str, T], broken: Broken, steps: Steps) -> None:
        self._entries, self._broken, self._steps = entries, broken, steps

    def extended(self, entries: Mapping[str, T]) -> Declared[T]:
        """These entries and others, which hide those of the same name."""
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
