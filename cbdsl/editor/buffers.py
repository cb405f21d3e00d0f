"""Texts of an editor, saved or not, and the checker's diagnostics in them."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from cbdsl.checking.safety_net import check_safely
from cbdsl.checking.session import Session
from cbdsl.diagnostics.diagnostic import Diagnostic
from cbdsl.diagnostics.diagnostics import Diagnostics
from cbdsl.diagnostics.errors import DiagnosticsError
from cbdsl.diagnostics.outcome import Unknown
from cbdsl.documents.document import Document
from cbdsl.documents.ownership import is_own
from cbdsl.types.resource import Resource
from cbdsl.yaml_text.document_folder import documents_below
from cbdsl.yaml_text.library import Library
from cbdsl.yaml_text.loaded import Loaded


class Buffers:
    """Texts that an editor has open.

    Documents that are not open are read from the disk, once, and again after ``forget``.

    Args:
        here: Folder in which documents are found by name.

    Attributes:
        here: Folder in which documents are found by name.
    """

    def __init__(self, here: Path) -> None:
        self.here = here
        self._texts: dict[Path, str] = {}
        self._session = self._new_session()

    def change(self, path: Path, text: str) -> None:
        """Take the text of a file from the editor."""
        self._texts[path] = text
        # Strict UTF-8 would raise an exception for a lone surrogate, which an editor can send. A
        # session cannot go on if a robot may have changed.
        if not self._session.replace(path, text.encode("utf-8", "surrogatepass")):
            self._session = self._new_session()

    def close(self, path: Path) -> None:
        """Take the text of a file from the disk again."""
        self._texts.pop(path, None)
        self._session = self._new_session()

    def forget(self) -> None:
        """Read documents that are not open from the disk again."""
        self._session = self._new_session()

    def text(self, path: Path) -> str:
        """Return the text of a file; empty if it cannot be read."""
        if path in self._texts:
            return self._texts[path]
        try:
            return self._session.library.text(path)
        except DiagnosticsError:
            return ""

    def documents(self) -> list[Path]:
        """Return the documents in the folder of the editor, and all open documents."""
        files = {path for path, text in self._texts.items() if is_own(path, text)}
        return sorted(files.union(documents_below(self.here).documents))

    @property
    def library(self) -> Library:
        """Documents by name, with the editor's texts."""
        return self._session.library

    def diagnostics(self, path: Path) -> list[Diagnostic]:
        """Return the diagnostics in a file."""
        # A document that was found by its name has a shorter path than the editor's.
        real, every = self.library.real, check_safely(path, self._session)
        return [each for each in every if real(Path(each.place.file)) == real(path)]

    def document(self, path: Path) -> Loaded[Document] | None:
        """Return the sound parts of a file, or ``None`` if there are none."""
        try:
            return self._session.library.read_sound_parts(path, Document)
        except DiagnosticsError:
            return None

    def resources(self, robot: Path) -> Mapping[str, Resource]:
        """Return the resources of the robot in a file; empty if its document has faults."""
        body = self._session.body(robot, Diagnostics())
        return {} if isinstance(body, Unknown) else body.resources

    def _new_session(self) -> Session:
        given = {path: text.encode("utf-8", "surrogatepass") for path, text in self._texts.items()}
        return Session(Library(self.here, given))
