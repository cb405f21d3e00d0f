"""Findings in documents, printed: what ``cb validate`` does once its words are read."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from cbdsl.errors.diagnostic import Diagnostic


def check_paths(paths: Iterable[str], values: Mapping[str, str], as_json: bool = False) -> int:
    """Check documents and folders of documents, and print what was found.

    Args:
        paths: files and folders.
        values: values of programs' parameters.
        as_json: whether to print for scripts.

    Returns:
        The exit code: 0 without errors, 1 with errors.

    Raises:
        UsageError: a folder holds no documents.
    """
    from cbdsl.checking.document import check_document
    from cbdsl.checking.session import Session
    from cbdsl.errors.counting import count

    session = Session()
    files = [file for path in paths for file in _documents(Path(path))]
    # A robot's findings come with every program on it: each is told once.
    found: dict[Diagnostic, None] = {}
    for file in files:
        found.update(dict.fromkeys(check_document(file, values, session)))
    if found or as_json:
        _tell(found, as_json)
    else:
        print(f"{count(len(files), 'document')}, no findings")
    return 1 if any(diagnostic.is_error for diagnostic in found) else 0


def _documents(path: Path) -> Iterator[Path]:
    """The file itself, or all documents below a folder."""
    from cbdsl.errors.errors import UsageError

    if not path.is_dir():
        yield path
        return
    files = sorted(file for file in path.rglob("*") if file.suffix in (".yaml", ".yml"))
    if not files:
        raise UsageError(f"{path} holds no documents (*.yaml)")
    yield from files


def _tell(found: Iterable[Diagnostic], as_json: bool) -> None:
    from cbdsl.cli.terminal import print_diagnostics, print_json

    if as_json:
        print_json([_plain(diagnostic) for diagnostic in found])
    else:
        print_diagnostics(found)


def _plain(value: object) -> object:
    """A diagnostic as JSON has it: places and the like become objects."""
    from enum import Enum

    if isinstance(value, Enum):
        return value.value
    if not isinstance(value, tuple):
        return value
    named = getattr(value, "_asdict", None)
    if named is None:
        return [_plain(part) for part in value]
    return {key: _plain(part) for key, part in named().items()}
