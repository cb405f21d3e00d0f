"""Files that a command line names: documents, folders of documents, and names."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

if TYPE_CHECKING:
    from cbdsl.yaml_text.document_folder import DocumentFolder
    from cbdsl.yaml_text.library import Library

#: Word for the standard input.
STANDARD_INPUT = "-"


class ChosenFiles(NamedTuple):
    """Files that a command line names.

    Attributes:
        files: Documents, each once, in the order of the words.
        others: Number of YAML files of other tools in the folders.
        unreadable: Number of folders that cannot be read.
    """

    files: tuple[Path, ...]
    others: int
    unreadable: int


def choose_files(words: Iterable[str], stdin: Path, library: Library) -> ChosenFiles:
    """Find the files that words mean: a file itself, documents below a folder or of a name.

    Args:
        words: Paths, names, and ``-`` for the standard input.
        stdin: File that the standard input stands for.
        library: Library that finds documents by name.

    Raises:
        UsageError: A folder holds no documents, or no document has a name.
    """
    # A dictionary keeps the first of equal paths, in order. `a.yaml .` names `a.yaml` twice.
    files: dict[Path, None] = {}
    others = unreadable = 0
    for word in words:
        if word == STANDARD_INPUT:
            files[stdin] = None
        elif Path(word).is_dir():
            below = _below(Path(word))
            files.update(dict.fromkeys(below.documents))
            others, unreadable = others + below.others, unreadable + below.unreadable
        else:
            files.update(dict.fromkeys(library.locate_any(word)))
    return ChosenFiles(tuple(files), others, unreadable)


def _below(folder: Path) -> DocumentFolder:
    from cbdsl.diagnostics.counting import count
    from cbdsl.diagnostics.errors import UsageError
    from cbdsl.yaml_text.document_folder import documents_below

    below = documents_below(folder)
    if not below.documents:
        others = f", only {count(below.others, 'YAML file')} of other tools" if below.others else ""
        raise UsageError(
            f"{folder} holds no documents (*.yaml with the keys 'cbdsl' and 'kind'){others}"
        )
    return below
