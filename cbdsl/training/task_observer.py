"""Observer of tasks, such as trials and explorations."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Generic, TypeVar

Item = TypeVar("Item")


class TaskObserver(Generic[Item]):
    """Observer of the items of tasks; a method ignores its call unless a subclass overrides it."""

    def begin(self, number: int, renderer: str, finished: Sequence[Item]) -> None:
        """Note that a task begins or goes on.

        Args:
            number: Number of the trial.
            renderer: Name of the renderer of the images.
            finished: Items that were finished earlier.
        """

    def note(self, number: int, item: Item) -> None:
        """Note that an item of trial ``number`` is finished."""


class ItemListener(TaskObserver[Item]):
    """Observer that keeps all items, and calls a function with each new one.

    Args:
        listener: Function of a new item.

    Attributes:
        items: Items so far, old and new.
    """

    def __init__(self, listener: Callable[[Item], object]) -> None:
        self._listener = listener
        self.items: list[Item] = []

    def begin(self, number: int, renderer: str, finished: Sequence[Item]) -> None:
        """Begin with the finished items."""
        self.items.extend(finished)

    def note(self, number: int, item: Item) -> None:
        """Keep an item, and call the function."""
        self.items.append(item)
        self._listener(item)
