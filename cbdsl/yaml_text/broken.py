"""Index of the faulty parts that were left out of a document."""

from __future__ import annotations

from collections.abc import Iterable

Steps = tuple[str | int, ...]


class Broken:
    """Set of paths of omitted parts, indexed so that no query about a path searches all of them."""

    def __init__(self, paths: Iterable[Steps] = ()) -> None:
        self._paths: set[Steps] = set()
        self._above: set[Steps] = set()
        self.add(paths)

    def add(self, paths: Iterable[Steps]) -> None:
        """Add the paths of omitted parts."""
        for path in paths:
            self._paths.add(path)
            self._above.update(path[:depth] for depth in range(len(path) + 1))

    def holds(self, *steps: str | int) -> bool:
        """Return whether exactly this path was left out."""
        return steps in self._paths

    def is_below(self, steps: Steps) -> bool:
        """Return whether a part at or below a path was left out."""
        return steps in self._above

    def touches(self, steps: Steps) -> bool:
        """Return whether a part at, above or below a path was left out."""
        above = (steps[:depth] for depth in range(1, len(steps) + 1))
        return self.is_below(steps) or any(path in self._paths for path in above)

    def keys(self, sections: Iterable[str]) -> Iterable[str]:
        """Return the keys of the entries that were left out of the given top-level sections."""
        inside = frozenset(sections)
        return (str(path[1]) for path in self._paths if len(path) == 2 and path[0] in inside)
