"""Check of playlists against the programs that they name."""

from itertools import pairwise

from cbdsl.checking.lookup.document_search import find_document
from cbdsl.checking.session import Session
from cbdsl.diagnostics.diagnostics import Diagnostics
from cbdsl.documents.program import ProgramDocument
from cbdsl.yaml_text.loaded import Loaded
from demo.playlist import REPEATED, PlaylistDocument


def check(loaded: Loaded[PlaylistDocument], session: Session, diagnostics: Diagnostics) -> None:
    """Check that every program exists, and that none follows itself."""
    if not loaded.source.is_whole("programs"):
        return
    document, library = loaded.document, session.library
    for place, name in enumerate(document.programs):
        where = loaded.source.place("programs", place)
        find_document(ProgramDocument, name, where, library, diagnostics, document.robot)
    for place, (name, following) in enumerate(pairwise(document.programs)):
        if name == following:
            diagnostics.add(REPEATED, loaded.source.place("programs", place + 1), name=name)
