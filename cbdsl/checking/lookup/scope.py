"""The parameters that are known at one point of a program."""

from __future__ import annotations

import re
from collections.abc import Mapping

from cbdsl.checking.findings import Findings
from cbdsl.errors.diagnostic import Place
from cbdsl.yaml_text.source_map import SourceMap, Step
from cbdsl.yaml_text.unknown import UNKNOWN, Declared

# Values made of values would double in length from program to program.
_LONGEST = 1_000
_PARAMETER = re.compile(r"\$([A-Za-z][A-Za-z0-9_]*)")
_NEGATED = re.compile(r"(^|[\[,])(\s*)-\$([A-Za-z][A-Za-z0-9_]*)")


class Scope:
    """Values of parameters, and which of them were asked for.

    Args:
        values: value by name.
        places: where values stand in the document, by name; others come from outside.
        used: what ``used`` begins with.

    Attributes:
        values: value by name.
        used: names that some text referred to; shared with the scopes inside.
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
        """Where a parameter's value stands, or ``None`` where it came from outside."""
        return self._places.get(name)

    def inside(self, values: Mapping[str, str], places: Mapping[str, Place]) -> Scope:
        """This scope with further parameters, which hide those of the same name."""
        visible = self.used if not values else _Hiding(self.used, frozenset(values))
        outer = {name: place for name, place in self._places.items() if name not in values}
        return Scope(self.values.extended(values), {**outer, **places}, visible)

    def substitute(
        self,
        text: str,
        source: SourceMap,
        steps: tuple[Step, ...],
        findings: Findings,
        offset: int = 0,
    ) -> str | None:
        """A text with ``$name`` replaced by values.

        Args:
            text: what is to be replaced in.
            source: the document that holds the text.
            steps: path of the value that holds it.
            findings: where unknown parameters go.
            offset: where in that value the text begins, from 0.

        Returns:
            ``None`` where a parameter is unknown, or the text would be too long.
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
                findings.add("CB402", place, names=sorted(self.values), name=name, hint=hint)
        if known and length > _LONGEST:
            findings.add("CB409", source.place(*steps), bound=_LONGEST)
            known = False
        if not known:
            return None
        text = _NEGATED.sub(self._negated, text)
        return _PARAMETER.sub(lambda match: self.values[match[1]], text)

    def _negated(self, match: re.Match[str]) -> str:
        """A quantity with the other sign: minus a negative one has none."""
        value = self.values[match[3]].lstrip()
        return f"{match[1]}{match[2]}{value[1:]}" if value.startswith("-") else match[0]


def parameters_in(text: str) -> list[str]:
    """The names of the parameters that a text refers to."""
    return [match[1] for match in _PARAMETER.finditer(text)]


class _Hiding(set[str]):
    """Passes on names to an outer set, except those that an inner scope hides."""

    def __init__(self, outer: set[str], hidden: frozenset[str]) -> None:
        super().__init__()
        self._outer = outer
        self._hidden = hidden

    def add(self, name: str) -> None:
        if name not in self._hidden:
            self._outer.add(name)
