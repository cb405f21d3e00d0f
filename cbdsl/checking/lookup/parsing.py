"""Parsing of a document's compositions, with reports of syntax errors."""

from __future__ import annotations

from cbdsl.diagnostics.diagnostics import Diagnostics
from cbdsl.diagnostics.outcome import UNKNOWN, Outcome
from cbdsl.language.expression import Expression
from cbdsl.language.parser import LookAlikeError, parse
from cbdsl.language.scanner import CompositionError
from cbdsl.yaml_text.source_map import SourceMap, Step

# Sections whose keys occur in compositions.
_CALLED = ("controllers", "use")


def parse_at(
    text: str, source: SourceMap, steps: tuple[Step, ...], diagnostics: Diagnostics
) -> Outcome[Expression]:
    """Return the composition at a path; unknown if the text is not valid."""
    try:
        return parse(text)
    except LookAlikeError as error:
        place = source.inside(steps, error.span.start, error.span.end)
        diagnostics.add("CB408", place, sign=error.sign, suggestion=error.suggestion)
    except CompositionError as error:
        if _is_of_a_faulty_name(text, source):
            return UNKNOWN
        place = source.inside(steps, error.span.start, error.span.end)
        diagnostics.add("CB401", place, problem=str(error))
    return UNKNOWN


def _is_of_a_faulty_name(text: str, source: SourceMap) -> bool:
    """Return whether a text mentions an invalid key such as ``track-it``."""
    return any(key in text and not key.isidentifier() for key in source.broken.keys(_CALLED))
