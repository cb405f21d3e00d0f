"""Writer of a document to a file that reads back as the same document."""

from __future__ import annotations

import errno
import os
import tempfile
from collections.abc import Iterable, Mapping
from contextlib import suppress
from glob import escape
from pathlib import Path
from typing import Any

import yaml

from cbdsl.documents.document import Document
from cbdsl.yaml_text import scalar
from cbdsl.yaml_text.characters import (
    escaped_invisible,
    invisible_in,
    suggested_key,
    suggested_value,
)


class _Dumper(yaml.SafeDumper):
    """Dumper that quotes exactly the texts that the reader would resolve to other types."""

    # PyYAML's stubs declare no class variable here.
    yaml_implicit_resolvers = {  # noqa: RUF012
        None: [
            ("tag:yaml.org,2002:null", scalar.NULL),
            ("tag:yaml.org,2002:bool", scalar.BOOLEAN),
            ("tag:yaml.org,2002:int", scalar.INTEGER),
            ("tag:yaml.org,2002:float", scalar.FLOAT),
            *(("tag:yaml.org,2002:float", refused) for refused in scalar.REFUSED),
        ]
    }

    def ignore_aliases(self, data: Any) -> bool:
        return True

    def represent_sequence(
        self, tag: str, sequence: Iterable[Any], flow_style: bool | None = None
    ) -> yaml.SequenceNode:
        """Represent a list of scalars in one line."""
        items = list(sequence)
        plain = not any(isinstance(item, (dict, list, tuple)) for item in items)
        return super().represent_sequence(tag, items, flow_style or plain)

    def text(self, data: str) -> yaml.ScalarNode:
        # YAML folds these line breaks into spaces unless they are escaped. The reader takes a
        # look-alike for a number or a name. Invisible characters have to be escaped.
        is_strange = not data.isascii() and (
            suggested_value(data) or suggested_key(data) or invisible_in(data)
        )
        style = '"' if is_strange or _BREAKS.intersection(data) else None
        return self.represent_scalar("tag:yaml.org,2002:str", data, style)


_BREAKS = frozenset("\x85\u2028\u2029")
_Dumper.add_representer(str, _Dumper.text)


def dump(document: Document) -> str:
    """Return a document as YAML, without values that equal their defaults."""
    return dump_plain(document.model_dump(mode="json", by_alias=True, exclude_defaults=True))


def dump_plain(data: Mapping[str, Any]) -> str:
    """Return the dicts, lists and scalars of a document as YAML, in their order."""
    text = yaml.dump(dict(data), Dumper=_Dumper, sort_keys=False, allow_unicode=True, width=100)
    return escaped_invisible(text)


def write(document: Document, path: Path) -> None:
    """Write a document atomically; see ``write_text``."""
    write_text(dump(document), path)


def make_room(path: Path) -> None:
    """Create the folder of a file, and check that the file can be written later.

    Raises:
        OSError: The folder cannot be created or written to.
    """
    path.parent.mkdir(parents=True, exist_ok=True)
    _require_replaceable(path)
    with tempfile.TemporaryFile(dir=path.parent):
        pass


def write_text(text: str, path: Path) -> None:
    """Write a file atomically, so that no reader sees a partial file.

    Raises:
        OSError: The file cannot be written.
    """
    write_bytes(text.encode("utf-8"), path)


def write_bytes(contents: bytes, path: Path) -> None:
    """Write a file atomically; see ``write_text``.

    Raises:
        OSError: The file cannot be written.
    """
    _require_replaceable(path)
    handle, temporary = tempfile.mkstemp(dir=path.parent, prefix=_prefix(path))
    try:
        with os.fdopen(handle, "wb") as file:
            file.write(contents)
            file.flush()
            os.fsync(file.fileno())  # before the rename replaces the old contents
        os.chmod(temporary, 0o644)
        os.replace(temporary, path)
    except BaseException:
        os.unlink(temporary)
        raise
    _sync_folder(path.parent)


def _sync_folder(folder: Path) -> None:
    """Flush the entries of a folder to disk, if its file system supports this."""
    with suppress(OSError):
        handle = os.open(folder, os.O_RDONLY | os.O_DIRECTORY)
        try:
            os.fsync(handle)
        finally:
            os.close(handle)


def _require_replaceable(path: Path) -> None:
    """Refuse a folder, and a device such as /dev/null, which a rename would replace.

    Raises:
        OSError: The path exists and is not a file.
    """
    if path.is_dir():
        raise IsADirectoryError(errno.EISDIR, os.strerror(errno.EISDIR), str(path))
    if path.exists() and not path.is_file():
        raise OSError(errno.EINVAL, "this is a device, not a file", str(path))


def remove_leftovers(path: Path) -> None:
    """Remove the temporary files of processes that were killed while they wrote a file.

    The caller must ensure that no process is writing the file.

    Raises:
        OSError: A temporary file cannot be removed.
    """
    for leftover in path.parent.glob(f"{escape(_prefix(path))}*"):
        leftover.unlink()


def _prefix(path: Path) -> str:
    return f".{path.name}.unfinished-"
