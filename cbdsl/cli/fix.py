"""``cb validate --fix``: corrections of misspelled names, written to the files."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from pathlib import Path

from cbdsl.cli.chosen_files import STANDARD_INPUT, choose_files
from cbdsl.editor.fixes import fixed
from cbdsl.errors.errors import DiagnosticsError

# The correction of one name may reveal another misspelled name.
_ROUNDS = 5


def fix_paths(paths: Iterable[str], values: Mapping[str, str]) -> None:
    """Correct what has a nearest name in documents and folders of documents, in place.

    Says on the standard error which files changed. Files are replaced as a whole.

    Args:
        paths: files and folders.
        values: values of programs' parameters.

    Raises:
        UsageError: there is nothing on the standard input to write to, or a folder is empty.
    """
    from cbdsl.cli.terminal import print_problem
    from cbdsl.errors.errors import UsageError

    words = list(paths)
    if STANDARD_INPUT in words:
        raise UsageError("--fix writes files; the standard input is none")
    changed: dict[Path, None] = {}
    for _ in range(_ROUNDS):
        now = _fix_once(words, values)
        changed.update(dict.fromkeys(now))
        if not now:
            break
    for path in changed:
        print_problem(f"fixed {path}")


def _fix_once(words: Iterable[str], values: Mapping[str, str]) -> list[Path]:
    """Correct each file once, and return the changed files."""
    from cbdsl.checking.document import check_document
    from cbdsl.checking.session import Session
    from cbdsl.yaml_text.library import Library
    from cbdsl.yaml_text.writer import write_text

    library, changed = Library(), []
    session = Session(library, values)
    for file in choose_files(words, Path(STANDARD_INPUT), library).files:
        own = [each for each in check_document(file, session) if each.place.file == str(file)]
        try:
            before = library.text(file)
        except DiagnosticsError:
            continue
        after = fixed(before, own)
        if after != before:
            write_text(after, file)
            changed.append(file)
    return changed
