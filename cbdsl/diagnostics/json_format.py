"""Diagnostics as JSON; ``docs/ci.md`` documents every key."""

from __future__ import annotations

import json
from typing import Any

from cbdsl.diagnostics.diagnostic import Diagnostic, Place
from cbdsl.diagnostics.validation_report import ValidationReport

#: Version, increased if a key changes its meaning or is removed, but not for a new key.
VERSION = 1


def json_report(report: ValidationReport) -> str:
    """Return a JSON object: version of the format, counts, and all diagnostics."""
    data = {
        "version": VERSION,
        "documents": report.documents,
        "errors": report.errors,
        "warnings": report.warnings,
        "notes": report.notes,
        "left_out": report.left_out,
        "others": report.others,
        "unreadable": report.unreadable,
        "findings": [_diagnostic(diagnostic) for diagnostic in report.diagnostics],
    }
    return json.dumps(data, indent=2, ensure_ascii=False)


def _diagnostic(diagnostic: Diagnostic) -> dict[str, Any]:
    return {
        "code": diagnostic.code,
        "severity": diagnostic.severity.value,
        "message": diagnostic.message,
        "place": _place(diagnostic.place),
        "nearest": diagnostic.nearest,
        "allowed": list(diagnostic.allowed),
        "related": [{"place": _place(r.place), "message": r.message} for r in diagnostic.related],
    }


def _place(place: Place) -> dict[str, Any]:
    return place._asdict()
