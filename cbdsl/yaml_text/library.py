"""Lookup of documents by name: beside the naming document, in a folder, or as shipped."""

from __future__ import annotations

import os
from collections import ChainMap
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

from cbdsl.diagnostics.diagnostics import Diagnostics
from cbdsl.diagnostics.errors import DiagnosticsError, UsageError
from cbdsl.diagnostics.nearest import suggestion
from cbdsl.documents.document import Document
from cbdsl.documents.kind import Kind
from cbdsl.documents.kinds import KINDS, kind_name, kind_of, kinds_with_resources, models
from cbdsl.documents.ownership import declared_kind
from cbdsl.storage.contents import contents, is_file, is_folder
from cbdsl.yaml_text.composer import MOST_BYTES
from cbdsl.yaml_text.document_folder import documents_below
from cbdsl.yaml_text.loaded import Loaded
from cbdsl.yaml_text.reader import decode, flawless, read_sound_parts, read_text

if TYPE_CHECKING:
    from cbdsl.yaml_text.shared_parts import SharedPart

D = TypeVar("D", bound=Document)


def shipped() -> Path:
    """Return the folder of the robots and programs that are shipped with the package."""
    package = Path(__file__).resolve().parent.parent
    installed = package / "shipped"
    return installed if installed.is_dir() else package.parent


class Library:
    """Reader of documents by name, which reads each file once.

    Attributes:
        here: Folder that is searched after the folders of the naming document.
    """

    def __init__(self, here: Path | None = None, given: Mapping[Path, bytes] | None = None) -> None:
        """Start with nothing read.

        Args:
            here: Folder to search; by default, the working folder.
            given: Contents that replace the bytes of files, such as unsaved editor buffers.
        """
        self.here = here or Path.cwd()
        self._given = {Path(os.path.realpath(path)): data for path, data in (given or {}).items()}
        self._read: dict[Path, Loaded[Any]] = {}
        self._bound = ChainMap[Path, Loaded[Any]]()
        self._parts: dict[Path, Mapping[str, SharedPart]] = {}
        self._files_by_name: dict[tuple[type[Document], str, Path | None], Path] = {}
        self._named: dict[Path, set[Path]] = {}
        self._real: dict[Path, Path] = {}

    def real(self, path: Path) -> Path:
        """Return the file with all links resolved; the result is cached."""
        if path not in self._real:
            # Path.resolve fails on cyclic links; reading the file reports them.
            self._real[path] = Path(os.path.realpath(path))
        return self._real[path]

    def find(self, kind: type[Document], name: str, beside: Path | None = None) -> Path | None:
        """Find ``<name>.yaml`` beside another file, else in a folder of its kind, else ``None``.

        Args:
            kind: Kind of document.
            name: Name of the document.
            beside: File whose folder and the folders above it are searched first.
        """
        key = (kind, name, beside and beside.parent)
        if key not in self._files_by_name:
            # Only documents that exist are cached, so that one is found as soon as it is written.
            path = self._search(kind, name, beside)
            if path is None:
                return None
            self._files_by_name[key] = path
        if beside is not None:
            self._named.setdefault(self.real(beside), set()).add(self._files_by_name[key])
        return self._files_by_name[key]

    @property
    def files(self) -> tuple[Path, ...]:
        """Files that have been read, with links resolved."""
        return tuple(self._read)

    def links_to(self, file: Path) -> set[Path]:
        """Return the symbolic links by which a file was found."""
        return {path for path, real in self._real.items() if real == file and path.is_symlink()}

    def model_kind(self, name: str, beside: Path) -> Kind | None:
        """Return the kind of the document that a program names below ``models``, if there is one.

        Args:
            name: Name of the document.
            beside: File of the program.
        """
        kinds = kinds_with_resources()
        return next((kind for kind in kinds if self.find(kind.model, name, beside)), None)

    def named_in(self, path: Path) -> set[Path]:
        """Return the files named by a document that were searched for and found."""
        return {self.real(file) for file in self._named.get(self.real(path), ())}

    def _search(self, kind: type[Document], name: str, beside: Path | None) -> Path | None:
        if beside is not None:
            # A sibling may have the same name and another kind. In a folder of its kind, a wrong
            # kind is a fault that the reader reports.
            sibling = beside.parent / f"{name}.yaml"
            if is_file(sibling) and is_of(kind, sibling):
                return _shortened(sibling)
        for folder in self._folders(kind, beside):
            path = folder / f"{name}.yaml"
            if is_file(path):
                return _shortened(path)
        return None

    def _folders(self, kind: type[Document], beside: Path | None) -> Iterator[Path]:
        """Yield the folders of a kind, the nearest to another file first."""
        folder = Path(kind_of(kind).folder)
        if beside is not None and len(folder.parts) > 1 and folder.name != beside.parent.name:
            # `stages` beside a program; as `cb learn` writes them, `models` beside any `policies`.
            yield from (near / folder.name for near in beside.absolute().parents[:2])
        for root in self._roots(beside):
            yield root / folder

    def names(self, kind: type[Document], beside: Path | None = None) -> list[str]:
        """Return the names of all documents of a kind that ``find`` can find."""
        names = {
            path.stem for folder in self._folders(kind, beside) for path in folder.glob("*.yaml")
        }
        if beside is not None:
            siblings = beside.parent.glob("*.yaml")
            names |= {path.stem for path in siblings if is_of(kind, path)}
        return sorted(names)

    def text(self, path: Path) -> str:
        """Return the text of a file.

        Raises:
            DiagnosticsError: The file cannot be read, or is not UTF-8.
        """
        given = self._given.get(self.real(path))
        return read_text(path) if given is None else decode(given, str(path))

    def read(self, path: Path, kind: type[D]) -> Loaded[D]:
        """Read a document, or return it from the cache.

        Raises:
            DiagnosticsError: The file is not a valid document of this kind.
        """
        return flawless(self.read_sound_parts(path, kind))

    def read_sound_parts(self, path: Path, kind: type[D]) -> Loaded[D]:
        """Read the sound parts of a document, or return them from the cache.

        Raises:
            DiagnosticsError: No part of the file can be checked.
        """
        return self._bound.get(self.real(path)) or self.read_as_written(path, kind)

    def read_as_written(self, path: Path, kind: type[D]) -> Loaded[D]:
        """Read the sound parts of a document without a robot in its roles.

        Raises:
            DiagnosticsError: No part of the file can be checked.
        """
        key = self.real(path)
        if key not in self._read or not isinstance(self._read[key].document, kind):
            loaded = self._read[key] = read_sound_parts(path, kind, self.text(path))
            if getattr(loaded.document, "shared", None):
                from cbdsl.yaml_text.shared_calls import with_shared  # few programs take any up

                self._read[key] = with_shared(loaded, self)
        return self._read[key]

    def shared_parts(self, path: Path) -> Mapping[str, SharedPart]:
        """Return the parts of a shared document by name, or those of an earlier call.

        Raises:
            DiagnosticsError: The file is not a valid document, or has a part that cannot be called.
        """
        from cbdsl.documents.shared import SharedDocument  # few programs take any up
        from cbdsl.yaml_text.shared_parts import shared_parts

        key, faults = self.real(path), Diagnostics()
        if key not in self._parts:
            parts = shared_parts(self.read(path, SharedDocument), faults)
            if faults.failed:
                raise DiagnosticsError(faults.sorted())
            self._parts[key] = parts
        return self._parts[key]

    def bind(self, loaded: Loaded[Any]) -> None:
        """Let readers of a program with roles see it with a robot in them, until the next one."""
        self._bound[self.real(loaded.path)] = loaded

    @contextmanager
    def bindings(self) -> Iterator[Mapping[Path, Loaded[Any]]]:
        """Collect the programs that are bound meanwhile, by file."""
        self._bound = self._bound.new_child()
        try:
            yield (made := self._bound.maps[0])
        finally:
            self._bound = self._bound.parents
            self.bind_again(made)

    def bind_again(self, bindings: Mapping[Path, Loaded[Any]]) -> None:
        """Let readers see collected programs with their robots."""
        self._bound.update(bindings)

    def replace(self, path: Path, data: bytes) -> bool:
        """Replace the contents of a file by other bytes, and drop its cached document.

        Returns:
            True if no cached robot can have changed. False if the file was or becomes a robot or
            a calibration, or if it is new, so that a name may refer to it.
        """
        key = self.real(path)
        before = self._given.get(key)
        self._given[key] = data
        self._read.pop(key, None)
        self._bound.clear()
        kinds = {declared_kind((each or b"").decode("utf-8", "replace")) for each in (before, data)}
        if "shared" in kinds:
            # Any program may hold parts of it.
            self._read.clear()
            self._parts.clear()
        if len(kinds) > 1:
            # A name refers to a file of one kind alone.
            self._files_by_name.clear()
        return before is not None and kinds.isdisjoint(("robot", "calibration"))

    def locate(self, kind: type[Document], name: str | Path) -> Path:
        """Return the file for a path, or for a name as a document in this folder would use it.

        Raises:
            UsageError: No document has this name.
        """
        path = Path(name)
        # A folder may have the name of a document, such as the folder of a robot's model.
        if path.suffix or len(path.parts) > 1 or is_file(path):
            return path
        # This path need not exist: it stands for a document in this folder.
        file = self.find(kind, str(name), self.here / path)
        if file is None:
            raise UsageError.unknown(kind_name(kind), str(name), self.names(kind, self.here / path))
        return file

    def locate_any(self, word: str) -> list[Path]:
        """Return the files for a path, or for a name among documents of all kinds.

        Raises:
            UsageError: No document has this name.
        """
        path = Path(word)
        if path.suffix or len(path.parts) > 1 or is_file(path):
            return [path]
        builtin = [KINDS.get(name).model for name in KINDS.builtins]
        # Package metadata is read only if the built-in kinds have no such document.
        files = self._files(word, builtin) or self._files(word, models().values())
        # A word may name both a document and a folder, such as a robot and the folder of its model.
        # The folder has precedence only if it holds documents.
        if is_folder(path) and (not files or documents_below(path).documents):
            return [path]
        if not files:
            raise UsageError(self._nothing_found(word))
        return list(dict.fromkeys(files))

    def _files(self, name: str, kinds: Iterable[type[Document]]) -> list[Path]:
        files = (self.find(kind, name, self.here / name) for kind in kinds)
        return [file for file in files if file is not None]

    def _nothing_found(self, name: str) -> str:
        *kinds, last = known = models()
        names = [n for kind in known.values() for n in self.names(kind, self.here / name)]
        return (
            f"there is no file '{name}', and no {', '.join(kinds)} or {last} of this "
            f"name{suggestion(name, names)} (a file is written with its folder and ending, as "
            f"programs/{name}.yaml)"
        )

    def _roots(self, beside: Path | None) -> Iterator[Path]:
        if beside is not None:
            yield from beside.absolute().parents
        yield self.here
        yield shipped()
        # Package metadata is read only for a name that is nowhere else.
        yield from (kind.brought for kind in KINDS.all().values() if kind.brought)


def is_of(kind: type[Document], path: Path) -> bool:
    """Return whether a file declares a kind; other faults of the file are not checked."""
    try:
        declared = declared_kind(contents(path, MOST_BYTES).decode("utf-8-sig"))
    except (OSError, UnicodeDecodeError):
        return False
    return declared == kind_name(kind)


def _shortened(path: Path) -> Path:
    """Return a path relative to the working folder if it is below it."""
    here = Path.cwd()
    return path.relative_to(here) if path.is_relative_to(here) else path
