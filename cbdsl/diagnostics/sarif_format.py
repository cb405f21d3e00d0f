"""Diagnostics in SARIF 2.1.0, the OASIS standard for the results of static analysis."""

from __future__ import annotations

import json
import os
from collections.abc import Sequence
from importlib.metadata import version
from pathlib import Path
from typing import Any
from urllib.parse import quote

from cbdsl.diagnostics.diagnostic import Diagnostic, Place
from cbdsl.diagnostics.entry import Entry
from cbdsl.diagnostics.published import page_of
from cbdsl.diagnostics.validation_report import ValidationReport

_SCHEMA = (
    "https://docs.oasis-open.org/sarif/sarif/v2.1.0/errata01/os/schemas/sarif-schema-2.1.0.json"
)


def sarif(report: ValidationReport) -> str:
    """Return a SARIF log of one run, with the codes of its diagnostics as rules."""
    codes = sorted({diagnostic.code for diagnostic in report.diagnostics})
    driver = {
        "name": "cbdsl",
        "version": version("cbdsl"),
        "rules": [_rule(entry) for code in codes if (entry := report.entry_of(code))],
    }
    run = {
        "tool": {"driver": driver},
        # Places count characters, and not UTF-16 units.
        "columnKind": "unicodeCodePoints",
        "invocations": [{"executionSuccessful": report.exit_code(strict=False) != 2}],
        "results": [_result(diagnostic, codes) for diagnostic in report.diagnostics],
    }
    log = {"$schema": _SCHEMA, "version": "2.1.0", "runs": [run]}
    return json.dumps(log, indent=2, ensure_ascii=False)


def _rule(entry: Entry) -> dict[str, Any]:
    page = page_of(entry.code)
    return {
        "id": entry.code,
        "shortDescription": {"text": entry.title},
        "fullDescription": {"text": entry.explanation},
        "help": {"text": entry.explanation, "markdown": entry.explanation},
        "defaultConfiguration": {"level": entry.severity.value},
        **({"helpUri": page} if page else {}),
    }


def _result(diagnostic: Diagnostic, codes: Sequence[str]) -> dict[str, Any]:
    suggestion = f"; did you mean '{diagnostic.nearest}'?" if diagnostic.nearest else ""
    result: dict[str, Any] = {
        "ruleId": diagnostic.code,
        "ruleIndex": codes.index(diagnostic.code),
        "level": diagnostic.severity.value,
        "message": {"text": diagnostic.message + suggestion},
        "locations": [_location(diagnostic.place)],
    }
    related = [
        {"id": i, **_location(other.place), "message": {"text": other.message}}
        for i, other in enumerate(diagnostic.related)
    ]
    return {**result, "relatedLocations": related} if related else result


def _location(place: Place) -> dict[str, Any]:
    region = {"startLine": place.line, "startColumn": place.column, "endColumn": place.end_column}
    return {"physicalLocation": {"artifactLocation": {"uri": _uri(place.file)}, "region": region}}


def _uri(file: str) -> str:
    """Return a path as a URI, which is relative if the path is."""
    path = Path(file)
    # Names on a disk are bytes, of any encoding.
    return path.as_uri() if path.is_absolute() else quote(os.fsencode(path.as_posix()))
