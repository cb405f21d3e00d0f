"""Check of playlists against the programs that they name."""

from itertools import pairwise

from cbdsl.extend.document import (
    Diagnostics,
    Loaded,
    ProgramDocument,
    Session,
    Unknown,
    find_document,
)
from demo.playlist import REPEATED, PlaylistDocument


def check(loaded: Loaded[PlaylistDocument], session: Session, diagnostics: Diagnostics) -> None:
    """Check that every program exists, and that none follows itself."""
    document, library = loaded.document, session.library
    programs = loaded.source.known(document.programs, "programs")
    if isinstance(programs, Unknown):
        return
    for place, name in enumerate(programs):
        where = loaded.source.place("programs", place)
        find_document(ProgramDocument, name, where, library, diagnostics, document.robot)
    for place, (name, following) in enumerate(pairwise(programs)):
        if name == following:
            diagnostics.add(REPEATED, loaded.source.place("programs", place + 1), name=name)
