"""Parameters that are defined at one point of a program."""

from __future__ import annotations

import re
from collections.abc import Mapping

from cbdsl.diagnostics.diagnostic import Place
from cbdsl.diagnostics.diagnostics import Diagnostics
from cbdsl.diagnostics.outcome import UNKNOWN, Outcome
from cbdsl.yaml_text.declared import Declared
from cbdsl.yaml_text.source_map import SourceMap, Step

# Values that refer to values could double in length from program to program.
_LONGEST = 1_000
_PARAMETER = re.compile(r"\$([A-Za-z][A-Za-z0-9_]*)")
# A reference may negate a parameter, as in ``[30 cm, -$side]``. For the value ``-10 cm``, plain
# replacement would give ``--10 cm``, which is not a quantity.
_NEGATED = re.compile(r"(^|[\[,])(\s*)-\$([A-Za-z][A-Za-z0-9_]*)")


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
        known, length = True, 0
        for match in _PARAMETER.finditer(text):
            name = match[1]
            self.used.add(name)
            value = self.values.get(name, UNKNOWN)
            length += len(value)
            known = known and value is not UNKNOWN
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
        text = _NEGATED.sub(self._negated, text)
        return _PARAMETER.sub(lambda match: self.values[match[1]], text)

    def _negated(self, match: re.Match[str]) -> str:
        """Return a quantity with the opposite sign: the two signs of a negative quantity cancel."""
        value = self.values[match[3]].lstrip()
        return f"{match[1]}{match[2]}{value[1:]}" if value.startswith("-") else match[0]


def parameters_in(text: str) -> list[str]:
    """Return the names of the parameters that a text refers to."""
    return [match[1] for match in _PARAMETER.finditer(text)]


class _Hiding(set[str]):
    """Set that adds names to an outer set, except names that an inner scope hides."""

    def __init__(self, outer: set[str], hidden: frozenset[str]) -> None:
        super().__init__()
        self._outer = outer
        self._hidden = hidden

    def add(self, name: str) -> None:
        if name not in self._hidden:
            self._outer.add(name)
