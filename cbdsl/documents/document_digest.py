"""Digests of documents by content."""

import json
from collections.abc import Iterable, Mapping
from typing import Any, NamedTuple

from cbdsl.documents.document import Document
from cbdsl.storage.digest import digest_of_text


class ProgramDigest(NamedTuple):
    """Digest of a program and of its learned policies.

    Attributes:
        sha256: Digest of the program without its own policy, and of the programs and models that
            it uses. Knowledge of a program is valid as long as this digest is unchanged.
        policies: SHA-256 of each learned policy that the program uses, directly or through other
            programs, with the models of the policy, by name.
        programs: SHA-256 of each other program that may replace this one or a member of it, with
            all that it uses, by name.
        shared: SHA-256 of each shared document that it takes up, by name. They explain a change of
            ``sha256``, which has the parts that the program calls.
    """

    sha256: str
    policies: Mapping[str, str]
    programs: Mapping[str, str]
    shared: Mapping[str, str] = {}


def digest(document: Document, leave_out: Iterable[str] = ()) -> str:
    """Return the SHA-256 of a document's content, in hexadecimal.

    The description, comments, layout and explicit default values do not change it. The content of a
    mesh counts, and its path does not. Drivers, roles and values of a robot do not count;
    values count in the programs that use them, as do the shared controllers that they take up.

    Args:
        document: Document.
        leave_out: Further keys at the top level that do not count.
    """
    # Knowledge stays valid as long as the digest of its inputs does. Omitted defaults let a new
    # optional key keep all digests, and aliases let a field change its Python name. The context
    # makes meshes count by content.
    left_out: dict[str, Any] = dict.fromkeys(("description", "drivers", "shared", *leave_out), True)
    if getattr(document, "kind", "") == "robot":
        left_out |= {"roles": True, "effectors": {"__all__": {"values": True}}}
    data = document.model_dump(
        mode="json",
        by_alias=True,
        exclude_defaults=True,
        exclude=left_out,
        context={"by_content": True},
    )
    # Sorted keys make the text independent of the order in the document.
    return digest_of_text(json.dumps(data, sort_keys=True, ensure_ascii=True))
