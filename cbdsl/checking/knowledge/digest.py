"""Digests of programs with all that they are made of."""

from __future__ import annotations

from pathlib import Path

from cbdsl.documents.digest import digest, digest_of_text
from cbdsl.documents.document import Document
from cbdsl.documents.model import ModelDocument
from cbdsl.documents.policy import PolicyDocument
from cbdsl.documents.program import ProgramDocument
from cbdsl.yaml_text.library import Library

# Of the program itself: what is learned stands in for its policy, on whatever stage.
_BESIDE_THE_POINT = ("policy", "stage")
# Of a learned policy: how it was learned.
_HISTORY = ("values", "transitions", "curve", "provenance")


def program_digest(path: Path, library: Library) -> str:
    """SHA-256 of a program without its own policy, and of the programs and models that it uses.

    Whatever was learned for a program holds for it as long as this is the same.

    Args:
        path: the file of a program without findings.
        library: where documents are found by name.
    """
    document = library.read(path, ProgramDocument).document
    return digest_of_text(digest(document, _BESIDE_THE_POINT) + _parts(document, path, library))


def _parts(document: ProgramDocument, path: Path, library: Library) -> str:
    used = sorted({(use.program, use.policy or "") for use in document.use.values()})
    programs = (_whole(program, policy, path, library) for program, policy in used)
    models = (
        digest(
            library.read(_document_file(ModelDocument, name, path, library), ModelDocument).document
        )
        for name in sorted(set(document.models.values()))
    )
    return "".join((*programs, *models))


def _whole(program: str, policy: str, beside: Path, library: Library) -> str:
    """Digest of a used program with its policy, its own or another, which matters here."""
    path = _document_file(ProgramDocument, program, beside, library)
    document = library.read(path, ProgramDocument).document
    own = digest(document, _BESIDE_THE_POINT if policy else ("stage",))
    return (
        own
        + (_learned(policy, beside, library) if policy else "")
        + _parts(document, path, library)
    )


def _learned(name: str, beside: Path, library: Library) -> str:
    """Digest of a policy with the models that belong to it."""
    path = _document_file(PolicyDocument, name, beside, library)
    document = library.read(path, PolicyDocument).document
    models = (
        library.read(_document_file(ModelDocument, model, path, library), ModelDocument)
        for _, model in sorted(document.models.items())
    )
    return "".join((digest(document, _HISTORY), *(digest(each.document) for each in models)))


def _document_file(kind: type[Document], name: str, beside: Path, library: Library) -> Path:
    path = library.find(kind, name, beside)
    assert path is not None, "a program without findings names documents that are there"
    return path
