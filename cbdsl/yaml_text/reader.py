"""From a file to a document and the places of its parts."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from typing import Any, Generic, NamedTuple, TypeVar

from pydantic import ValidationError

from cbdsl.documents.document import Document
from cbdsl.documents.kinds import KINDS, kind_name, models
from cbdsl.errors.diagnostic import Diagnostic, Place
from cbdsl.errors.errors import DiagnosticsError, UsageError
from cbdsl.errors.lines import lines_of
from cbdsl.errors.nearest import nearest_name
from cbdsl.errors.wording import diagnostic
from cbdsl.yaml_text.composer import compose
from cbdsl.yaml_text.node import Node
from cbdsl.yaml_text.source_map import SourceMap

D = TypeVar("D", bound=Document, covariant=True)


class Loaded(NamedTuple, Generic[D]):
    """A document and where its parts stand.

    Attributes:
        document: without what is faulty.
        source: its text.
        faults: what is wrong with the text; ``source.broken`` says what was left out.
    """

    document: D
    source: SourceMap
    faults: tuple[Diagnostic, ...] = ()

    @property
    def path(self) -> Path:
        """Its file."""
        return self.source.path


def read_document(path: Path) -> Loaded[Document]:
    """Read a document of any kind.

    Raises:
        DiagnosticsError: the file cannot be read, or is no valid document.
    """
    return read(path, Document)


def read(path: Path, kind: type[D], text: str | None = None) -> Loaded[D]:
    """Read a document of one kind.

    Args:
        path: its file.
        kind: the kind that it has to be of.
        text: what stands in for the file's text.

    Raises:
        DiagnosticsError: as ``read_document``, or where the document is of another kind.
    """
    return flawless(read_sound_parts(path, kind, text))


def flawless(loaded: Loaded[D]) -> Loaded[D]:
    """The same document, if nothing was left out of it.

    Raises:
        DiagnosticsError: its faults.
    """
    if loaded.faults:
        raise DiagnosticsError(loaded.faults)
    return loaded


def read_sound_parts(path: Path, kind: type[D], text: str | None = None) -> Loaded[D]:
    """Read what has no faults of a document of one kind; the arguments are those of ``read``.

    Raises:
        DiagnosticsError: there is nothing that could be checked.
    """
    text = read_text(path) if text is None else text
    composed = compose(text, str(path))
    source = SourceMap(path, composed.lines, composed.root)
    model, found = _model(source, composed.findings)
    if not issubclass(model, kind):
        wanted = kind_name(kind)
        given = str(source.node(("kind",)).value)
        raise _error("CB201", source.place("kind"), wanted=wanted, found=given)
    if not found:
        try:
            return Loaded(model.model_validate(source.root.plain()), source)
        except ValidationError:
            pass  # it is read again, part by part
    from cbdsl.yaml_text.repair.salvage import salvage  # only a fault needs it

    document, faults, broken = salvage(source, model, found)
    return Loaded(document, source._replace(broken=broken), faults)


def _named_alike(path: Path) -> list[str]:
    """The document beside a missing one that was probably meant.

    Endings do not count: all have the same, which would make any two short names alike.
    """
    beside = {file.stem: file.name for file in path.parent.glob("*.y*ml")}
    nearest = nearest_name(path.stem, beside)
    return [str(path.with_name(beside[nearest]))] if nearest else []


def read_text(path: Path) -> str:
    """The text of a file.

    Raises:
        DiagnosticsError: it cannot be read, or is not UTF-8.
    """
    try:
        data = path.read_bytes()
    except OSError as error:
        reason = error.strerror or str(error)
        where, beside = Place(str(path)), _named_alike(path)
        raise _error("CB101", where, candidates=beside, reason=reason, name=str(path)) from None
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


def _model(
    source: SourceMap, found: tuple[Diagnostic, ...]
) -> tuple[type[Document], tuple[Diagnostic, ...]]:
    """The kind of document that a text is, and what was found with what it says of that."""
    root = source.root
    if not isinstance(root.value, dict):
        from cbdsl.yaml_text.repair.fault import describe  # only a fault needs it

        described = describe(root.value)
        raise _error("CB204", root.place, found, expected="a mapping", found=described)
    kind: Node | None = root.value.get("kind")
    if kind is not None and (kind.faulty or any(part.faulty for part in kind.children())):
        raise DiagnosticsError(found)
    said = None if kind is None else str(kind.value)
    model = None if said is None else _model_of(said)
    meant = _contradicted(root.value, said, model)
    is_right = model is not None and meant is None
    wrong = () if is_right else (_wrong_kind(source, said, model, meant),)
    model = _model_of(meant) if meant else model
    if model is None:
        raise DiagnosticsError([*found, *wrong])
    place = root.place if kind is None else kind.place
    root.value["kind"] = Node(place, kind_name(model))
    return model, (*found, *wrong)


def _model_of(kind: str) -> type[Document] | None:
    """The model of a kind; ``None`` where there is none that can be used."""
    try:
        return KINDS.get(kind).model
    except UsageError:
        return None


def _contradicted(
    keys: Iterable[str], said: str | None, model: type[Document] | None
) -> str | None:
    """The kind that the keys of a document are those of, where it says that it is another."""
    if model is not None and model.model_fields.keys() >= set(keys):
        return None
    from cbdsl.yaml_text.repair.kind import kind_by_keys  # only a fault needs it

    return kind_by_keys(keys, said, models())


def _wrong_kind(
    source: SourceMap, said: str | None, model: type[Document] | None, meant: str | None
) -> Diagnostic:
    """What is to be said of a kind that is missing, unknown or contradicted by the keys."""
    if said is None:
        names = [meant] if meant else list(models())
        return diagnostic("CB203", source.root.place, names=names, key="kind")
    place = source.place("kind")
    if model is None:
        return diagnostic("CB206", place, names=list(models()), name=said)
    from cbdsl.yaml_text.repair.kind import telling_keys  # only a fault needs it

    assert meant is not None, "nothing is wrong with it otherwise"
    keys = ", ".join(telling_keys(source.root.keys, meant, said, models()))
    return diagnostic("CB210", place, said=said, found=meant, keys=keys)


def _error(
    code: str, place: Place, before: tuple[Diagnostic, ...] = (), **details: Any
) -> DiagnosticsError:
    return DiagnosticsError([*before, diagnostic(code, place, **details)])
