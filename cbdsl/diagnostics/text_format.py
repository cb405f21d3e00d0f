"""Diagnostics as text: each with its line, a caret, and the allowed names."""

from __future__ import annotations

import os
import sys

from cbdsl.diagnostics.counting import count
from cbdsl.diagnostics.validation_report import ValidationReport


def text(report: ValidationReport) -> str:
    """Return the diagnostics and their numbers as text, in colour for a terminal."""
    if not report.diagnostics:
        return f"{count(report.documents, 'document')}, no findings{_skipped(report)}"
    from cbdsl.diagnostics.rendering import render  # documents without diagnostics do without

    color = _is_colorful()
    lines = [render(d, report.text_of(d.place.file), color) for d in report.diagnostics]
    return "\n".join([*lines, _tally(report)])


def _tally(report: ValidationReport) -> str:
    numbers = {"error": report.errors, "warning": report.warnings, "note": report.notes}
    tally = ", ".join(count(number, noun) for noun, number in numbers.items() if number)
    left_out = f"; {report.left_out} more are left out" if report.left_out else ""
    return tally + left_out + _skipped(report)


def _skipped(report: ValidationReport) -> str:
    """Return the number of unchecked files, after a semicolon; empty if there are none."""
    others = count(report.others, "YAML file")
    skipped = f"; {others} of other tools skipped" if report.others else ""
    folders = count(report.unreadable, "folder")
    unreadable = f"; {folders} cannot be read" if report.unreadable else ""
    return skipped + unreadable


def _is_colorful() -> bool:
    """Return whether the standard output shows colours and the user has not disabled them."""
    wanted = "NO_COLOR" not in os.environ and os.environ.get("TERM") != "dumb"
    return wanted and sys.stdout.isatty()
