"""Brackets and quotes that are not closed, or followed by more than fits."""

from __future__ import annotations

import re

from cbdsl.yaml_text.repair.reported_error import (
    NO_CONTENT,
    NO_ITEM,
    NO_KEY,
    OPEN,
    OPENED,
    ReportedError,
    TextCorrection,
)

_ROW = re.compile(r"\[[^\[\]{}]*\]")


def after_the_end(reported: ReportedError) -> TextCorrection | None:
    """Detect text after a bracket or a quote that closes a value."""
    before, rest = reported.before.rstrip(), reported.rest.rstrip()
    if reported.problem not in (NO_KEY, NO_ITEM) or before[-1:] not in ("]", "}", "'", '"'):
        return None
    if rest in (",", ";"):
        problem = f"leave out the '{rest}' at the end of the line"
        return TextCorrection(
            problem, reported.line, reported.column, lines=reported.instead(before)
        )
    if set(rest) <= {"]", "}"}:
        problem = f"unmatched '{rest}'; remove it"
        return TextCorrection(
            problem, reported.line, reported.column, lines=reported.instead(before)
        )
    problem = (
        f"'{rest}' cannot follow the '{before[-1]}', which ends the value; a unit stands behind "
        "each number, and a comment behind ' #'"
    )
    return TextCorrection(problem, reported.line, reported.column)


def row_in_text(reported: ReportedError) -> TextCorrection | None:
    """Detect a text within braces that holds a row, such as a displaced reference."""
    if reported.problem not in OPENED:
        return None
    row = _ROW.match(reported.rest)
    # Text that continues with a row, as a displaced reference does.
    text = reported.before[_after_signs(reported.before) :].lstrip()
    if row is None or len(text.rstrip(" ")) < 2 or text.rstrip(" ")[-1] not in "+-":
        return None
    start = len(reported.before) - len(text)
    quoted = f'"{text}{row[0]}"'
    line = reported.before[:start] + quoted + reported.rest[row.end() :]
    problem = f"within braces, a text with brackets must be quoted; write {quoted}"
    return TextCorrection(problem, reported.line, start + 1, "CB124", reported.instead(line))


def _after_signs(text: str) -> int:
    """Return the place behind the last sign of YAML that ends a text within braces."""
    return max(text.rfind(sign) for sign in ",[]{}:") + 1


def within_brackets(reported: ReportedError) -> TextCorrection | None:
    """Detect an unclosed bracket, or a missing comma within brackets."""
    if reported.problem not in OPENED:
        return None
    opening, closing = OPENED[reported.problem]
    line, column = reported.opened
    at = reported.rest[:1]
    if at in ("]", "}"):
        problem = f"this '{at}' does not close the '{opening}' in line {line}; write '{closing}'"
        return TextCorrection(problem, reported.line, reported.column)
    # In [${gain}], the brace begins a mapping within the text.
    if reported.before.endswith("$"):
        problem = "a parameter is written without braces, as $name"
        return TextCorrection(problem, reported.line, reported.column)
    if reported.at_end or reported.is_outside:
        problem = f"this '{opening}' is never closed; a '{closing}' is missing"
        return TextCorrection(problem, line, column)
    problem = "a ',' is missing before this"
    if at == ":":
        problem += " key, or the text before it holds ': ' and needs quotes"
    if ";" in reported.before:
        problem = "in brackets values are parted by ',', not by ';'"
    return TextCorrection(problem, reported.line, reported.column)


def open_quote(reported: ReportedError) -> TextCorrection | None:
    if reported.problem != OPEN:
        return None
    return TextCorrection("this quote is never closed", reported.line, reported.column)


def _never_closed(reported: ReportedError) -> TextCorrection | None:
    """Detect an unclosed bracket at the end of a text."""
    line = reported.above
    before = reported.lines[line - 1].partition(" #")[0].rstrip()
    closing = {"[": "]", "{": "}"}.get(before[-1:])
    if closing is None:
        return None
    problem = f"this '{before[-1]}' is never closed; a '{closing}' is missing"
    return TextCorrection(problem, line, len(before))


def missing_value(reported: ReportedError) -> TextCorrection | None:
    if reported.problem != NO_CONTENT:
        return None
    if reported.at_end:
        return _never_closed(reported)
    at = reported.rest[:1]
    problem = f"a value is missing before this '{at}', or the '{at}' is one too many"
    return TextCorrection(problem, reported.line, reported.column)
