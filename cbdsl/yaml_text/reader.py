"""Reader of a file into a document and the places of its parts."""

from __future__ import annotations

import errno
from pathlib import Path
from typing import Any, TypeVar

from pydantic import ValidationError

from cbdsl.diagnostics.diagnostic import Diagnostic, Place
from cbdsl.diagnostics.errors import DiagnosticsError, UsageError
from cbdsl.diagnostics.lines import lines_of
from cbdsl.diagnostics.nearest import nearest_name
from cbdsl.diagnostics.wording import diagnose
from cbdsl.documents.document import Document
from cbdsl.documents.kinds import KINDS
from cbdsl.storage.contents import contents
from cbdsl.yaml_text.characters import is_suspect
from cbdsl.yaml_text.composer import (
    MOST_BYTES,
    Composed,
    YamlSyntaxError,
    compose,
    require_readable,
    too_large,
)
from cbdsl.yaml_text.loaded import Invalid, Loaded
from cbdsl.yaml_text.source_map import SourceMap

D = TypeVar("D", bound=Document, covariant=True)


def read_document(path: Path) -> Loaded[Document]:
    """Read a document of any kind.

    Raises:
        DiagnosticsError: The file cannot be read, or is not a valid document.
    """
    return read(path, Document)


def read(path: Path, kind: type[D], text: str | None = None) -> Loaded[D]:
    """Read a document of one kind.

    Args:
        path: File of the document.
        kind: Required kind of document.
        text: Text that replaces the file's text.

    Raises:
        DiagnosticsError: As ``read_document``, or the document is of another kind.
    """
    return flawless(read_sound_parts(path, kind, text))


def flawless(loaded: Loaded[D]) -> Loaded[D]:
    """Return the same document if it has no faults.

    Raises:
        DiagnosticsError: The document has faults.
    """
    if loaded.diagnostics:
        raise DiagnosticsError(loaded.diagnostics)
    return loaded


def read_sound_parts(path: Path, kind: type[D], text: str | None = None) -> Loaded[D]:
    """Read the sound parts of a document of one kind; the arguments are the same as of ``read``.

    A sound document is validated once, and one with faults twice: a repair goes on with the errors
    of the first validation. See ``salvage`` for faults in several layers, which need more.

    Raises:
        DiagnosticsError: No part of the document can be checked.
    """
    text = read_text(path) if text is None else text
    return read_composed(path, kind, text, _composed(path, text))


def read_composed(path: Path, kind: type[D], text: str, composed: Composed | None) -> Loaded[D]:
    """Read the sound parts of a document from its nodes; ``None`` for a text that has none.

    Raises:
        DiagnosticsError: No part of the document can be checked.
    """
    outcome = None if composed is None else _read_clean(path, kind, composed)
    if isinstance(outcome, Loaded):
        return outcome
    from cbdsl.yaml_text.repair.repair import repair  # only a fault needs it

    return repair(path, kind, text, composed, outcome)


def formatted_text(text: str, file: str) -> str:
    """Format the text of a document; see ``formatted``.

    The result has the same values and the same diagnostics as the text. A text whose diagnostics
    depend on its spaces, such as one with a decimal comma, is returned unchanged.

    Args:
        text: Text of the document.
        file: Name of its file, for diagnostics.

    Raises:
        DiagnosticsError: The text is too large, or not valid YAML.
    """
    from cbdsl.yaml_text.formatter import formatted  # most reading needs none

    require_readable(text, file)
    try:
        result = formatted(text)
    except YamlSyntaxError:
        from cbdsl.yaml_text.repair.repair import repair

        raise DiagnosticsError(repair(Path(file), Document, text).diagnostics) from None
    path = Path(file)
    return result if result == text or _reading(path, result) == _reading(path, text) else text


def _reading(path: Path, text: str) -> tuple[Document | None, list[tuple[str, str, str | None]]]:
    """Return the document read from a text, and its diagnostics without their places."""
    document: Document | None = None
    faults: tuple[Diagnostic, ...]
    try:
        loaded = read_sound_parts(path, Document, text)
        document, faults = loaded.document, loaded.diagnostics
    except DiagnosticsError as error:
        faults = error.diagnostics
    return document, [(each.code, each.message, each.nearest) for each in faults]


def _composed(path: Path, text: str) -> Composed | None:
    """Return the nodes of a text, or ``None`` if it is not valid YAML or needs repair."""
    if is_suspect(text):
        return None
    try:
        return compose(text, str(path))
    except (YamlSyntaxError, DiagnosticsError):
        return None


def _read_clean(path: Path, kind: type[D], composed: Composed) -> Loaded[D] | Invalid | None:
    """Return a document of one kind, its errors, or ``None`` if its text may have other faults."""
    try:
        data = composed.root.plain()
        name = data.get("kind") if isinstance(data, dict) else None
        if composed.diagnostics or not isinstance(name, str):
            return None
        model = KINDS.get(name).model
        if not issubclass(model, kind):
            return None
    except (DiagnosticsError, UsageError):
        return None
    try:
        relative = model.is_for_any_robot(data)
        context = {"folder": path.parent, "relative": relative}
        document = model.model_validate(data, context=context)
    except ValidationError as error:
        return Invalid(model, tuple(error.errors(include_url=False)))
    return Loaded(document, SourceMap(path, composed.lines, composed.root))


def _named_alike(path: Path) -> list[str]:
    """Return the most similarly named document in the folder of a missing one, as a list.

    File endings are ignored, because a shared ending would make any two short names similar.
    """
    near = (file.name for file in path.parent.glob("*.y*ml") if file.name != path.name)
    beside = {Path(name).stem: name for name in near}
    nearest = nearest_name(path.stem, beside)
    return [str(path.with_name(beside[nearest]))] if nearest else []


def read_text(path: Path) -> str:
    """Return the text of a file.

    Raises:
        DiagnosticsError: The file cannot be read, is too large, or is not UTF-8.
    """
    try:
        data = contents(path, MOST_BYTES)
    except OSError as error:
        if error.errno == errno.EFBIG:
            raise too_large(str(path)) from None
        reason = error.strerror or str(error)
        beside = _named_alike(path) if isinstance(error, FileNotFoundError) else []
        details = {"reason": reason, "name": str(path)}
        raise _error("CB101", Place(str(path)), candidates=beside, **details) from None
    return decode(data, str(path))


def decode(data: bytes, file: str) -> str:
    """Decode bytes as UTF-8, without a leading byte order mark.

    Raises:
        DiagnosticsError: The bytes are too many, or not UTF-8.
    """
    if len(data) > MOST_BYTES:
        raise too_large(file)
    try:
        return data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        before = lines_of(data[: error.start].decode("utf-8-sig", "replace"))
        place = Place(file, len(before), len(before[-1]) + 1, len(before[-1]) + 2)
        raise _error("CB102", place, byte=f"0x{data[error.start]:02X}") from None


def _error(code: str, place: Place, **details: Any) -> DiagnosticsError:
    return DiagnosticsError([diagnose(code, place, **details)])
