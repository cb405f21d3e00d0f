"""Correction of unambiguous mistakes in invalid YAML, so that they hide no other diagnostics."""

from __future__ import annotations

from itertools import islice

from cbdsl.diagnostics.diagnostic import Diagnostic, Place
from cbdsl.diagnostics.errors import DiagnosticsError
from cbdsl.diagnostics.lines import lines_of
from cbdsl.diagnostics.wording import diagnose
from cbdsl.yaml_text.characters import invisible_in, without_invisible
from cbdsl.yaml_text.composer import (
    Composed,
    YamlSyntaxError,
    compose,
    require_readable,
    require_short_lines,
    unseen,
)
from cbdsl.yaml_text.repair.conflict import conflicts, one_side
from cbdsl.yaml_text.repair.syntax import find_correction

# Further mistakes in a text are found once these are corrected.
_MOST_CORRECTIONS = 10


def mend(text: str, file: str, known: Composed | None = None) -> Composed:
    """Compose the single document of a text, with mistakes corrected; lines keep their numbers.

    Args:
        text: Text as written.
        file: Name of the file in diagnostics.
        known: Nodes of the text as written, if they are already composed.

    Raises:
        DiagnosticsError: A fatal diagnostic, together with all diagnostics up to it.
    """
    require_readable(text, file)
    given, (text, diagnostics) = text, _legible(text, file)
    if known is not None and text == given:
        return known._replace(diagnostics=(*diagnostics, *known.diagnostics))
    # Each round adds a diagnostic, and their number is bounded, so that the loop ends even if
    # corrections do not help.
    while True:
        try:
            composed = compose(text, file)
        except YamlSyntaxError as fault:
            require_short_lines(text, file)
            correction = find_correction(fault.error, lines_of(text))
            place = Place(file, correction.line, correction.column, correction.column + 1)
            diagnostics.append(diagnose(correction.code, place, problem=correction.problem))
            if not correction.lines or len(diagnostics) >= _MOST_CORRECTIONS:
                raise DiagnosticsError([*diagnostics, *fault.diagnostics]) from None
            text = "\n".join(correction.mended(lines_of(text)))
        except DiagnosticsError as error:
            raise DiagnosticsError([*diagnostics, *error.diagnostics]) from None
        else:
            return composed._replace(diagnostics=(*diagnostics, *composed.diagnostics))


def _legible(text: str, file: str) -> tuple[str, list[Diagnostic]]:
    """Return a text without invisible characters and conflicts, and the diagnostics about these."""
    diagnostics = []
    if invisible := invisible_in(text):
        # One diagnostic represents all: invisible characters tend to occur in large numbers.
        diagnostics.append(unseen("CB118", invisible, file))
        text = without_invisible(text)
    lines = lines_of(text)
    diagnostics += islice(conflicts(lines, file), _MOST_CORRECTIONS)
    return "\n".join(one_side(lines)), diagnostics
