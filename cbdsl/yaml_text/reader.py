"""From a file to a document and the places of its parts."""

from __future__ import annotations

from pathlib import Path
from typing import Any, Generic, NamedTuple, TypeVar

from pydantic import ValidationError

from cbdsl.documents.document import Document
from cbdsl.documents.model import ModelDocument
from cbdsl.documents.policy import PolicyDocument
from cbdsl.documents.program import ProgramDocument
from cbdsl.documents.robot import RobotDocument
from cbdsl.documents.stage import StageDocument
from cbdsl.errors.diagnostic import Place
from cbdsl.errors.errors import DiagnosticsError
from cbdsl.errors.lines import lines_of
from cbdsl.errors.wording import diagnostic
from cbdsl.yaml_text.composer import compose
from cbdsl.yaml_text.faults import describe, faults
from cbdsl.yaml_text.node import Node
from cbdsl.yaml_text.source_map import SourceMap

KINDS: dict[str, type[Document]] = {
    "robot": RobotDocument,
    "program": ProgramDocument,
    "stage": StageDocument,
    "policy": PolicyDocument,
    "model": ModelDocument,
}

D = TypeVar("D", bound=Document, covariant=True)


class Loaded(NamedTuple, Generic[D]):
    """A document and where its parts stand."""

    document: D
    source: SourceMap

    @property
    def path(self) -> Path:
        """Its file."""
        return self.source.path


def read_document(path: Path) -> Loaded[Document]:
    """Read a document of any kind.

    Raises:
        DiagnosticsError: the file cannot be read, or is no valid document.
    """
    source = _source(path)
    return _load(source, _model(source))


def read(path: Path, kind: type[D], text: str | None = None) -> Loaded[D]:
    """Read a document of one kind.

    Args:
        path: its file.
        kind: the kind that it has to be of.
        text: what stands in for the file's text.

    Raises:
        DiagnosticsError: as ``read_document``, or where the document is of another kind.
    """
    source = _source(path, text)
    model = _model(source)
    if not issubclass(model, kind):
        wanted = next(name for name, known in KINDS.items() if known is kind)
        found = str(source.node(("kind",)).value)
        raise _error("CB201", source.place("kind"), wanted=wanted, found=found)
    return _load(source, model)


def read_text(path: Path) -> str:
    """The text of a file.

    Raises:
        DiagnosticsError: it cannot be read, or is not UTF-8.
    """
    try:
        data = path.read_bytes()
    except OSError as error:
        reason = error.strerror or str(error)
        raise _error("CB101", Place(str(path)), reason=reason) from None
    return decode(data, str(path))


def decode(data: bytes, file: str) -> str:
    """The text that bytes hold; a byte order mark at its start is left out.

    Raises:
        DiagnosticsError: they are not UTF-8.
    """
    try:
        return data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        before = lines_of(data[: error.start].decode("utf-8-sig", "replace"))
        place = Place(file, len(before), len(before[-1]) + 1, len(before[-1]) + 2)
        raise _error("CB102", place, byte=f"0x{data[error.start]:02X}") from None


def _source(path: Path, text: str | None = None) -> SourceMap:
    text = read_text(path) if text is None else text
    return SourceMap(path, lines_of(text), compose(text, str(path)))


def _model(source: SourceMap) -> type[Document]:
    if not isinstance(source.root.value, dict):
        found = describe(source.root.value)
        raise _error("CB204", source.root.place, expected="a mapping", found=found)
    kind: Node | None = source.root.value.get("kind")
    if kind is None:
        raise _error("CB203", source.root.place, key="kind")
    if str(kind.value) not in KINDS:
        raise _error("CB206", kind.place, names=list(KINDS), name=str(kind.value))
    return KINDS[str(kind.value)]


def _load(source: SourceMap, model: type[D]) -> Loaded[D]:
    try:
        return Loaded(model.model_validate(source.root.plain()), source)
    except ValidationError as error:
        details = error.errors(include_url=False)
        raise DiagnosticsError(faults(details, source, model)) from None


def _error(code: str, place: Place, **details: Any) -> DiagnosticsError:
    return DiagnosticsError([diagnostic(code, place, **details)])
