"""Parameters that are defined at one point of a program."""

from __future__ import annotations

from collections.abc import Mapping

from cbdsl.diagnostics.diagnostic import Place
from cbdsl.diagnostics.diagnostics import Diagnostics
from cbdsl.diagnostics.outcome import UNKNOWN, Outcome, Unknown
from cbdsl.language.parameters import filled, parameters_in
from cbdsl.yaml_text.declared import Declared
from cbdsl.yaml_text.source_map import SourceMap, Step

# Values that refer to values could double in length from program to program.
_LONGEST = 1_000


class Scope:
    """Values of parameters, and the names of the used ones.

    Args:
        values: Value by name.
        places: Places of values in the document, by name; other values come from outside.
        used: Initial set of used names.

    Attributes:
        values: Value by name.
        used: Names that some text referred to; shared with the scopes inside.
    """

    def __init__(
        self,
        values: Declared[str],
        places: Mapping[str, Place],
        used: set[str] | None = None,
    ) -> None:
        self.values = values
        self._places = places
        self.used: set[str] = set() if used is None else used

    def place(self, name: str) -> Place | None:
        """Return the place of a parameter's value, or ``None`` if it came from outside."""
        return self._places.get(name)

    def inside(self, values: Mapping[str, str], places: Mapping[str, Place]) -> Scope:
        """Return this scope with further parameters, which hide those of the same name."""
        visible = self.used if not values else _Hiding(self.used, frozenset(values))
        outer = {name: place for name, place in self._places.items() if name not in values}
        return Scope(self.values.extended(values), {**outer, **places}, visible)

    def substitute(
        self,
        text: str,
        source: SourceMap,
        steps: tuple[Step, ...],
        diagnostics: Diagnostics,
        offset: int = 0,
    ) -> Outcome[str]:
        """Return a text with ``$name`` replaced by values.

        Args:
            text: Text with parameters.
            source: Source map of the document that holds the text.
            steps: Path of the value that holds it.
            diagnostics: Diagnostics so far.
            offset: Index in that value at which the text begins, from 0.

        Returns:
            Text; unknown if a parameter is, or if the text would be too long.
        """
        known, length, values = True, 0, dict[str, str]()
        for match in parameters_in(text):
            name = match[1]
            self.used.add(name)
            value = self.values.get(name, UNKNOWN)
            if isinstance(value, Unknown):
                known = False
            else:
                values[name] = value
                length += len(value)
            if name not in self.values:
                place = source.inside(steps, offset + match.start() + 1, offset + match.end() + 1)
                hint = "" if self.values else "; declare it in 'parameters'"
                diagnostics.add("CB402", place, names=sorted(self.values), name=name, hint=hint)
        # The length is checked before the text exists, because the text may not fit into memory.
        if known and length > _LONGEST:
            diagnostics.add("CB409", source.place(*steps), bound=_LONGEST)
            known = False
        if not known:
            return UNKNOWN
        return filled(text, values)


class _Hiding(set[str]):
    """Set that adds names to an outer set, except names that an inner scope hides."""

    def __init__(self, outer: set[str], hidden: frozenset[str]) -> None:
        super().__init__()
        self._outer = outer
        self._hidden = hidden

    def add(self, name: str) -> None:
        if name not in self._hidden:
            self._outer.add(name)
