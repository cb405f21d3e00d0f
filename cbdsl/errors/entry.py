"""An entry of the catalogue of diagnostics."""

from collections.abc import Mapping
from types import MappingProxyType
from typing import NamedTuple

from cbdsl.errors.diagnostic import Severity


class Entry(NamedTuple):
    """What there is to say about one code.

    Attributes:
        code: ``CB`` and three digits.
        title: the fault in a few words.
        message: what a diagnostic says; the names in braces are filled in.
        explanation: why it is a fault, and the way out.
        example: the text of a document that has the fault; ``None``: a file that does not exist.
        path: where the example is, relative to a folder of documents.
        beside: other files that the example needs, by path.
        severity: whether the document can still be used.
    """

    code: str
    title: str
    message: str
    explanation: str
    example: str | bytes | None
    path: str = "programs/example.yaml"
    beside: Mapping[str, str] = MappingProxyType({})
    severity: Severity = Severity.ERROR
