"""Search for documents by name, with proposals for a name that is unknown."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from cbdsl.diagnostics.diagnostic import Place
from cbdsl.diagnostics.diagnostics import Diagnostics
from cbdsl.diagnostics.errors import DiagnosticsError
from cbdsl.diagnostics.outcome import UNKNOWN, Outcome, Unknown
from cbdsl.documents.document import Document
from cbdsl.documents.kinds import kind_of
from cbdsl.types.relative import ANY_ROBOT
from cbdsl.yaml_text.library import Library


def find_document(
    kind: type[Document],
    name: str,
    place: Place,
    library: Library,
    diagnostics: Diagnostics,
    robot: str | None = None,
    own: str = "",
) -> Outcome[Path]:
    """Return the file of a document, or report it as missing unless its name is unknown.

    Args:
        kind: Kind of the document.
        name: Name of the document.
        place: Place of that name.
        library: Library that finds documents by name.
        diagnostics: Diagnostics so far.
        robot: Required robot of the document, or ``None`` if unknown.
        own: Name of the referring document, if it cannot be meant.
    """
    beside = Path(place.file)
    if isinstance(name, Unknown):
        return UNKNOWN
    path = library.find(kind, name, beside)
    if path is not None:
        return path
    names = (
        library.names(kind, beside) if robot is None else for_robot(kind, robot, beside, library)
    )
    # A document cannot use itself, so that its own name is not a useful suggestion.
    names = [each for each in names if each != own]
    diagnostics.add(kind_of(kind).unknown, place, names=names, name=name)
    return UNKNOWN


def for_robot(
    kind: type[Document],
    robot: str,
    beside: Path | None,
    library: Library,
    *,
    others: Sequence[str] = (ANY_ROBOT,),
) -> list[str]:
    """Return the names of the documents of a kind that are for a robot.

    Args:
        kind: Kind of the documents; if it has no reference to a robot, no document suits.
        robot: Robot's name.
        beside: File that would name them, if there is one.
        library: Library that finds documents by name.
        others: Robots whose documents are for this one, too.
    """
    suitable = []
    key = next((k for k, of in kind_of(kind).references.items() if of == "robot"), "")
    for name in library.names(kind, beside):
        file = library.find(kind, name, beside)
        try:
            document = None if file is None else library.read_sound_parts(file, kind).document
        except DiagnosticsError:
            continue
        if getattr(document, key, None) in (robot, *others):
            suitable.append(name)
    return suitable
