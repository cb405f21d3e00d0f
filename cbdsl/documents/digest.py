"""Digests of documents by content."""

import hashlib
import json
from collections.abc import Iterable, Mapping
from typing import NamedTuple

from cbdsl.documents.document import Document


class ProgramDigest(NamedTuple):
    """Digest of a program, and of the learned policies that run inside of it.

    Attributes:
        sha256: of the program without its own policy, and of the programs and models that it uses;
            whatever was learned for a program holds for it as long as this is the same.
        policies: SHA-256 of each learned policy that it uses, itself or by a program that it uses,
            with the models that belong to it, by name.
    """

    sha256: str
    policies: Mapping[str, str]


def digest(document: Document, leave_out: Iterable[str] = ()) -> str:
    """SHA-256 of a document's content, in hexadecimal.

    Its description, comments and layout do not matter, nor does a default that is written out. Of a
    mesh its content counts, and not where it lies. A robot's drivers do not change its body.

    Args:
        document: the document.
        leave_out: keys at its top that do not matter either.
    """
    data = document.model_dump(
        mode="json",
        by_alias=True,
        exclude_defaults=True,
        exclude={"description", "drivers", *leave_out},
        context={"by_content": True},
    )
    return digest_of_text(json.dumps(data, sort_keys=True, ensure_ascii=True))


def digest_of_text(text: str) -> str:
    """SHA-256 of a text, in hexadecimal."""
    return hashlib.sha256(text.encode()).hexdigest()
