"""Mistakes that cause YAML syntax errors, often before the place that libyaml reports."""

from __future__ import annotations

import re
from collections.abc import Sequence

import yaml

from cbdsl.yaml_text import characters
from cbdsl.yaml_text.repair.bracket import (
    after_the_end,
    missing_value,
    open_quote,
    row_in_text,
    within_brackets,
)
from cbdsl.yaml_text.repair.layout import find_shift
from cbdsl.yaml_text.repair.missing_colon import (
    colon_above,
    foreign_comment,
    missing_colon,
    second_colon,
)
from cbdsl.yaml_text.repair.reported_error import (
    ALIAS,
    NO_DIRECTIVE,
    NO_ITEM,
    NO_KEY,
    NO_MAPPING,
    NO_START,
    NO_TOKEN,
    ReportedError,
    TextCorrection,
    reported_error,
)

_STATE_IN_BRACKETS = re.compile(r"\s*(?P<state>[\[({][X01*,\s-]+[\])}])\s*:(?=\s)")
_UNQUOTED_KEY = re.compile(r"(?P<text>[^\s:#]+)(?=\s*:(?:\s|$))")
_UNQUOTED = re.compile(r"(?P<text>[^,\[\]{}#]*[^,\[\]{}#\s])")
_FENCE = re.compile(r"\s*(?:```|~~~)\w*\s*\Z")


def find_correction(error: yaml.MarkedYAMLError, lines: Sequence[str]) -> TextCorrection:
    """Return the mistake that causes a syntax error, or else libyaml's message.

    Args:
        error: Error of libyaml.
        lines: Lines of the text.
    """
    # libyaml may report an error after the last line.
    reported = reported_error(error, [*lines, ""])
    corrections = (
        (explain(reported) for explain in _EXPLANATIONS) if reported.line <= len(lines) + 1 else ()
    )
    correction = next((correction for correction in corrections if correction is not None), None)
    return correction or TextCorrection(reported.problem, reported.line, reported.column)


def _tab(reported: ReportedError) -> TextCorrection | None:
    if reported.rest[:1] != "\t":
        return None
    return TextCorrection("a tab", reported.line, reported.column, "CB117")


def _look_alike(reported: ReportedError) -> TextCorrection | None:
    """Detect a look-alike of a space, a bullet or a colon, in this line or the one above."""
    for number in (reported.line, reported.above):
        line = reported.lines[number - 1]
        suggestion = characters.suggested_line(line) if number else None
        if suggestion is not None:
            problem = characters.look_alike_message(line, suggestion)
            column = characters.first_look_alike(line) + 1
            return TextCorrection(problem, number, column, "CB123", {number: suggestion})
    return None


def _fence(reported: ReportedError) -> TextCorrection | None:
    if not _FENCE.match(reported.text):
        return None
    problem = "this line marks a block of code in a text, and is not a part of it; delete it"
    fences = (n for n, line in enumerate(reported.lines, 1) if _FENCE.match(line))
    return TextCorrection(problem, reported.line, 1, lines=dict.fromkeys(fences, ""))


def _unquoted(reported: ReportedError) -> TextCorrection | None:
    """Detect an unquoted text that begins with a sign of YAML."""
    if reported.context == ALIAS:
        line, column = reported.opened
    elif reported.problem == NO_TOKEN:
        line, column = reported.line, reported.column
    else:
        return None
    text = reported.lines[line - 1]
    before, rest = text[: column - 1], text[column - 1 :]
    if state := _STATE_IN_BRACKETS.match(text):
        return _state_in_brackets(state, line)
    key = _UNQUOTED_KEY.match(rest)
    match = key or _UNQUOTED.match(rest)
    if match is None:
        return None
    quoted = f"'{match['text'].strip('`')}'"
    problem = f"a text that begins with '{rest[0]}' must be quoted; write {quoted}"
    # Only the schema can decide whether a value may begin with such a sign.
    is_certain = key is not None or rest[0] == "`"
    mended = {line: before + quoted + rest[match.end() :]} if is_certain else {}
    return TextCorrection(problem, line, column, "CB124", mended)


def _state_in_brackets(state: re.Match[str], line: int) -> TextCorrection:
    letters = re.sub(r"[^X01*-]", "", state["state"])
    text = f"{state.string[: state.start('state')]}'{letters}'{state.string[state.end('state') :]}"
    problem = f"a state has no brackets and no commas; write '{letters}'"
    return TextCorrection(problem, line, state.start("state") + 1, "CB124", {line: text})


def _directive(reported: ReportedError) -> TextCorrection | None:
    return foreign_comment(reported) if reported.problem == NO_DIRECTIVE else None


def _indentation(reported: ReportedError) -> TextCorrection | None:
    """Detect a line that is indented differently from its neighbours."""
    if reported.problem not in (NO_KEY, NO_ITEM, NO_MAPPING):
        return None
    shift = find_shift(reported.lines, reported.line)
    return shift and TextCorrection(shift.problem, shift.line, shift.column, "CB121", shift.lines)


def _before_the_document(reported: ReportedError) -> TextCorrection | None:
    """Detect a line before or after the document that forms a second document."""
    if reported.problem != NO_START:
        return None
    number = reported.above or reported.line
    if reported.lines[number - 1].startswith("..."):
        return TextCorrection("'...' ends the document; leave it out", number, 1)
    problem = "only a comment can stand before or behind the keys of a document; delete this line"
    return TextCorrection(problem, number, 1)


# Each function tests one hypothesis about the mistake, and the first one that applies is reported.
# The order matters. Signs that are wrong in every context come first. Functions for the same
# messages of libyaml go from the specific to the general, such as from a row in a text to any
# bracket. Indentation comes late, because most syntax errors disturb the levels of the lines around
# them.
_EXPLANATIONS = (
    _tab, _look_alike, _fence, _unquoted, _directive, missing_colon, after_the_end, row_in_text,
    within_brackets, open_quote, second_colon, colon_above, _indentation, missing_value,
    _before_the_document,
)  # fmt: skip
