"""Diagnostics as workflow commands, which GitHub shows beside the lines of a pull request."""

from __future__ import annotations

from pathlib import Path

from cbdsl.diagnostics.diagnostic import Diagnostic, Severity
from cbdsl.diagnostics.legible_text import one_line
from cbdsl.diagnostics.validation_report import ValidationReport

_COMMANDS = {Severity.ERROR: "error", Severity.WARNING: "warning", Severity.NOTE: "notice"}
# Escapes of characters that workflow commands reserve; the escape sign itself comes first.
_IN_MESSAGES = {"%": "%25", "\r": "%0D", "\n": "%0A"}
_IN_PROPERTIES = {**_IN_MESSAGES, ":": "%3A", ",": "%2C"}


def github(report: ValidationReport) -> str:
    """Return one workflow command per diagnostic, each on a line."""
    return "\n".join(_annotation(diagnostic) for diagnostic in report.diagnostics)


def _annotation(diagnostic: Diagnostic) -> str:
    place = diagnostic.place
    properties = {
        "file": Path(place.file).as_posix(),
        "line": place.line,
        "col": place.column,
        "endLine": place.line,
        "endColumn": place.end_column,
        "title": diagnostic.code,
    }
    written = ",".join(
        f"{key}={_escaped(str(value), _IN_PROPERTIES)}" for key, value in properties.items()
    )
    return (
        f"::{_COMMANDS[diagnostic.severity]} {written}"
        f"::{_escaped(_message(diagnostic), _IN_MESSAGES)}"
    )


def _message(diagnostic: Diagnostic) -> str:
    """Return the message, the suggested name, and the related places."""
    suggestion = [f"did you mean '{diagnostic.nearest}'?"] if diagnostic.nearest else []
    related = [f"{related.place}: {related.message}" for related in diagnostic.related]
    return "\n".join(map(one_line, [diagnostic.message, *suggestion, *related]))


def _escaped(text: str, escapes: dict[str, str]) -> str:
    for character, escape in escapes.items():
        text = text.replace(character, escape)
    return text
