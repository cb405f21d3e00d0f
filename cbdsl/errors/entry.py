"""An entry of the catalogue of diagnostics."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from types import MappingProxyType

from cbdsl.errors.diagnostic import Severity


@dataclass(frozen=True)
class Entry:
    """One code: title, message, explanation and examples.

    Attributes:
        code: ``CB`` and three digits.
        title: the fault in a few words.
        message: what a diagnostic says; the names in braces are filled in.
        explanation: why it is a fault, and the way out.
        bad: the text of a document that has the fault; ``None``: a file that does not exist.
        path: where the examples are, relative to a folder of documents.
        beside: other files that the examples need, by path.
        severity: whether the document can still be used.
        good: the text of the same document without the fault.
    """

    code: str
    title: str
    message: str
    explanation: str
    bad: str | bytes | None
    path: str = "programs/example.yaml"
    beside: Mapping[str, str] = field(default_factory=lambda: MappingProxyType({}))
    severity: Severity = Severity.ERROR
    good: str = field(kw_only=True)
