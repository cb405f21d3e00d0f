"""Entry of the catalogue of diagnostics."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from types import MappingProxyType

from cbdsl.diagnostics.diagnostic import Severity


@dataclass(frozen=True)
class Entry:
    """One code: title, message, explanation and examples.

    Attributes:
        code: ``CB`` and three digits.
        title: Fault in a few words.
        message: Message template of a diagnostic; the names in braces are filled in.
        explanation: Reason why it is a fault, and the remedy.
        bad: Text of a document that has the fault; ``None`` for a file that does not exist.
        path: Path of the examples, relative to a folder of documents.
        beside: Other files that the examples need, by path.
        severity: Severity, which decides whether the document can still be used.
        good: Text of the same document without the fault.
    """

    code: str
    title: str
    message: str
    explanation: str
    bad: str | bytes | None
    path: str = "programs/example.yaml"
    beside: Mapping[str, str | bytes] = field(default_factory=lambda: MappingProxyType({}))
    severity: Severity = Severity.ERROR
    good: str = field(kw_only=True)
