"""Parameters of a program."""

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

    Attributes:
        values: Value by name.
        used: Names that some text referred to.
    """

    def __init__(self, values: Declared[str], places: Mapping[str, Place]) -> None:
        self.values = values
        self._places = places
        self.used: set[str] = set()

    def place(self, name: str) -> Place | None:
        """Return the place of a parameter's value, or ``None`` if it came from outside."""
        return self._places.get(name)

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
