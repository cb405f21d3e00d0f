"""Keys that are one level too high or too low, and where they belong.

If a section is written flat, or at the level of its parent, its keys are unknown in their mapping.
They are known in a section inside or around it, and are moved there. One mistake thus
yields one diagnostic, and the rest is checked as intended.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from itertools import islice, takewhile
from typing import NamedTuple

from pydantic import BaseModel

from cbdsl.diagnostics.diagnostic import Diagnostic, Place
from cbdsl.diagnostics.wording import diagnose
from cbdsl.yaml_text.node import Node
from cbdsl.yaml_text.repair.schema_shape import SchemaShape
from cbdsl.yaml_text.source_map import SourceMap, Step

Steps = tuple[Step, ...]

# Further names are summarized as a number.
_MOST_NAMES = 4


class Move(NamedTuple):
    """Move of misplaced keys.

    Attributes:
        keys: Names of the keys, in order.
        start: Path of the mapping that holds them.
        goal: Path of the mapping to which they belong.
        followers: Subsequent keys that belong below the last of them.
    """

    keys: tuple[str, ...]
    start: Steps
    goal: Steps
    followers: tuple[str, ...] = ()


def find_moves(source: SourceMap, model: type[BaseModel], wrong: Iterable[Steps]) -> list[Move]:
    """Return the moves of misplaced keys, at most one for each mapping.

    Args:
        source: Source map of the document.
        model: Model of the kind of document.
        wrong: Paths of values with faults.
    """
    at_or_above = {path[:depth] for path in wrong for depth in range(len(path) + 1)}
    return list(_Finder(at_or_above).below(source.root, SchemaShape((model,)), (), ()))


def move(source: SourceMap, moved: Move) -> Diagnostic:
    """Move keys to the mapping to which they belong, and return the diagnostic."""
    fault = diagnose(
        "CB209", source.key(*moved.start, moved.keys[0]), problem=_message(source, moved)
    )
    start = source.node(moved.start)
    _put(start, moved.keys, _mapping(source, moved.goal, start.keys[moved.keys[0]]))
    if moved.followers:
        goal = (*moved.goal, moved.keys[-1])
        _put(start, moved.followers, _mapping(source, goal, source.key(*goal)))
    return fault


def _mapping(source: SourceMap, path: Steps, place: Place) -> Node:
    """Return the mapping at a path, or insert a new one."""
    if source.holds(*path) and isinstance(source.node(path).value, dict):
        return source.node(path)
    parent, key = source.node(path[:-1]), str(path[-1])
    assert isinstance(parent.value, dict)
    parent.value[key] = Node(parent.keys.setdefault(key, place), {})
    return parent.value[key]


def _put(start: Node, keys: Iterable[str], goal: Node) -> None:
    assert isinstance(start.value, dict)
    assert isinstance(goal.value, dict)
    for key in keys:
        goal.value[key], goal.keys[key] = start.value.pop(key), start.keys.pop(key)


def _message(source: SourceMap, moved: Move) -> str:
    names = [f"'{key}'" for key in moved.keys[:_MOST_NAMES]]
    if len(moved.keys) > _MOST_NAMES:
        names[-1] = f"{len(moved.keys) - len(names) + 1} more keys"
    them, belong = ("it", "belongs") if len(names) == 1 else ("them", "belong")
    what = f"{', '.join(names[:-1])} and {names[-1]}" if len(names) > 1 else names[0]
    if not moved.goal:
        return f"{what} {belong} to the document itself; do not indent {them}"
    section = str(moved.goal[-1])
    if source.holds(*moved.goal):
        return f"{what} {belong} to '{section}'; indent {them} below that key"
    start = source.node(moved.start)
    assert isinstance(start.value, dict)
    values = (f"{key}: {source.written(start.value[key])}" for key in moved.keys)
    own = "its own" if them == "it" else "their own"
    return f"{what} {belong} below a key of {own}; write '{section}: {{{', '.join(values)}}}'"


class _Enclosing(NamedTuple):
    """Mapping on the path to a value."""

    path: Steps
    node: Node
    shape: SchemaShape

    def lacks(self, key: str) -> bool:
        """Return whether the mapping may have a key but does not."""
        value = self.node.value
        return key in self.shape.keys and isinstance(value, dict) and key not in value


#: Mappings around a value, outermost first.
Around = tuple[_Enclosing, ...]


class _Fit(NamedTuple):
    """Fit of unknown keys into a section.

    Attributes:
        section: Key of the section.
        keys: Keys that the section accepts.
        is_lacking: True if the section is present and incomplete without them.
    """

    section: str
    keys: tuple[str, ...]
    is_lacking: bool

    @property
    def rank(self) -> tuple[int, bool]:
        return len(self.keys), self.is_lacking


class _Finder:
    def __init__(self, wrong: set[Steps]) -> None:
        self._wrong = wrong

    def below(self, node: Node, shape: SchemaShape, path: Steps, around: Around) -> Iterator[Move]:
        """Yield the moves of keys in a value and in the values below it."""
        if path not in self._wrong and not isinstance(node.value, dict):
            return
        here = (*around, _Enclosing(path, node, shape))
        if isinstance(node.value, dict):
            moved = (
                self._names(node, shape, path)
                if shape.is_of_names
                else self._keys(node, shape, path)
            )
            moved = moved or self._upwards(node, shape, path, around)
            if moved is not None:
                yield moved
                return
        for step, child in node.steps():
            inner = shape.child(step)
            # A name equal to a key of entries is not a name: the entry's own name is missing.
            if not (shape.is_of_names and step in inner.keys):
                yield from self.below(child, inner, (*path, step), here)

    def _keys(self, node: Node, shape: SchemaShape, path: Steps) -> Move | None:
        """Return the move of keys unknown in a section but known in a section inside it."""
        assert isinstance(node.value, dict)
        unknown = [key for key in node.value if key not in shape.keys]
        if not shape.keys or not unknown:
            return None
        for parent in list(node.value)[:-1]:
            # A key without a value, followed by keys of its own section, as if these were not
            # indented.
            is_empty = parent in shape.keys and node.value[parent].value is None
            if is_empty and (keys := self._children(node, shape, parent)):
                return Move(keys, path, (*path, parent))
        fits = [self._fit(node, shape, section, unknown) for section in shape.keys]
        best = max((fit.rank for fit in fits), default=(0, False))
        chosen = [fit for fit in fits if fit.keys and fit.rank == best]
        # Two sections that fit equally well are ambiguous, so that nothing is moved.
        return Move(chosen[0].keys, path, (*path, chosen[0].section)) if len(chosen) == 1 else None

    def _children(self, node: Node, shape: SchemaShape, parent: str) -> tuple[str, ...]:
        """Return the keys after an empty key that belong to it."""
        assert isinstance(node.value, dict)
        inner, keys = shape.child(parent), list(node.value)
        behind = keys[keys.index(parent) + 1 :]
        if inner.is_of_names:
            return tuple(takewhile(lambda key: key not in shape.keys, behind))
        return tuple(takewhile(lambda key: key in inner.keys, behind))

    def _fit(self, node: Node, shape: SchemaShape, section: str, unknown: list[str]) -> _Fit:
        """Return the fit of the unknown keys that complete an inner section."""
        assert isinstance(node.value, dict)
        inner, child = shape.child(section), node.value.get(section)
        has = child.value if child is not None else {}
        if not isinstance(has, dict) or inner.is_of_names:
            return _Fit(section, (), False)
        keys = tuple(key for key in unknown if key in inner.keys and key not in has)
        # The keys have to complete the section. Otherwise one misspelt key could move to a section
        # that merely has a key of this name.
        if not inner.is_complete({*has, *keys}):
            return _Fit(section, (), False)
        return _Fit(section, keys, child is not None and not inner.is_complete(set(has)))

    def _names(self, node: Node, shape: SchemaShape, path: Steps) -> Move | None:
        """Return the move of the keys of an entry that are written beside its name."""
        assert isinstance(node.value, dict)
        known = shape.child("").keys
        keys = list(node.value)
        for index, name in enumerate(keys[:-1], 1):
            run = tuple(takewhile(lambda key: key in known, islice(keys, index, None)))
            if name not in known and run and self._belong(node.value[name], run, path):
                return Move(run, path, (*path, name))
        return None

    def _belong(self, above: Node, run: tuple[str, ...], path: Steps) -> bool:
        """Return whether the keys after an entry belong to it.

        They do if the entry is empty, or if they are all invalid beside it and absent in it.
        """
        if above.value is None or not isinstance(above.value, dict):
            return above.value is None
        return all((*path, key) in self._wrong and key not in above.value for key in run)

    def _upwards(self, node: Node, shape: SchemaShape, path: Steps, around: Around) -> Move | None:
        """Return the move of a key that belongs to an enclosing section, with the keys after it."""
        assert isinstance(node.value, dict)
        for key, child in node.value.items():
            is_foreign = shape.is_of_names or not (key in shape.keys or key in shape.moved)
            is_wrong = (*path, key) in self._wrong and is_foreign
            goal = _around(key, around) if is_wrong else None
            if goal is not None:
                # A key without a value opens a section, to which the keys behind it belong.
                keys = list(node.value)
                behind = keys[keys.index(key) + 1 :] if child.value is None else []
                return Move((key,), path, goal, tuple(behind))
        return None


def _around(key: str, around: Around) -> Steps | None:
    """Return the path of the nearest enclosing section that may have this key but lacks it."""
    return next((level.path for level in around[::-1] if level.lacks(key)), None)
