"""The parts of a document that were left out because they are faulty."""

from __future__ import annotations

from collections.abc import Iterable

Steps = tuple[str | int, ...]


class Broken:
    """Paths of what was left out, for questions that take no search among them."""

    def __init__(self, paths: Iterable[Steps] = ()) -> None:
        self._paths: set[Steps] = set()
        self._above: set[Steps] = set()
        self.add(paths)

    def add(self, paths: Iterable[Steps]) -> None:
        """Leave out more."""
        for path in paths:
            self._paths.add(path)
            self._above.update(path[:depth] for depth in range(len(path) + 1))

    def holds(self, *steps: str | int) -> bool:
        """Whether a path itself was left out."""
        return steps in self._paths

    def is_below(self, steps: Steps) -> bool:
        """Whether something was left out at or below a path."""
        return steps in self._above

    def touches(self, steps: Steps) -> bool:
        """Whether something was left out at, above or below a path."""
        above = (steps[:depth] for depth in range(1, len(steps) + 1))
        return self.is_below(steps) or any(path in self._paths for path in above)

    def keys(self, sections: Iterable[str]) -> Iterable[str]:
        """Keys of what was left out of some sections of the document."""
        inside = frozenset(sections)
        return (str(path[1]) for path in self._paths if len(path) == 2 and path[0] in inside)
