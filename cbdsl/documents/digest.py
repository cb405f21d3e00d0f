"""Digests of documents by content."""

import hashlib
import json
from collections.abc import Iterable

from cbdsl.documents.document import Document


def digest(document: Document, leave_out: Iterable[str] = ()) -> str:
    """SHA-256 of a document's content, in hexadecimal.

    Its description, comments and layout do not matter, nor does a default that is written out.

    Args:
        document: the document.
        leave_out: keys at its top that do not matter either.
    """
    data = document.model_dump(
        mode="json", by_alias=True, exclude_defaults=True, exclude={"description", *leave_out}
    )
    return digest_of_text(json.dumps(data, sort_keys=True, ensure_ascii=True))


def digest_of_text(text: str) -> str:
    """SHA-256 of a text, in hexadecimal."""
    return hashlib.sha256(text.encode()).hexdigest()
